// A convex hull: vertices, faces and edges in fixed arrays, built at set-up and never changed.
//
// Frame: the body's own, origin at the centre of mass, axes along the principal axes. Units: m, kg, kg m^2.
// A Shape refers to a hull by its index in the list that both worlds get at set-up (Hulls). So a body stays a small
// value, and a tape can be replayed after loading the same scene. Thread: make_hull [setup]; the rest [any], read only.
// Bound: 64 vertices; a closed convex surface of 64 vertices has at most 124 faces and 186 edges (Euler).
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "rt/base/spatial.h"

namespace tactus::physics {

inline constexpr std::uint32_t kMaxHullVertices = 64;
inline constexpr std::uint32_t kMaxHullFaces = 2 * kMaxHullVertices - 4;  // fills whole registers
inline constexpr std::uint32_t kMaxHullEdges = 3 * kMaxHullVertices - 6;

// A directed edge; seen from outside, `left` is the face to the left of the direction from -> to.
struct HullEdge {
  std::uint8_t from, to, left, right;
  friend constexpr bool operator==(const HullEdge&, const HullEdge&) noexcept = default;
};

// Connectivity of vertices, edges and faces, without coordinates. Loops run counter-clockwise seen from outside.
struct HullTopology {
  std::uint32_t vertices{0}, faces{0}, edges{0};
  std::array<std::uint16_t, kMaxHullFaces + 1> loop_start{};    // loop of face f: from loop_start[f] to [f + 1]
  std::array<std::uint8_t, 2 * kMaxHullEdges> loop_vertices{};  // the vertices of all loops
  std::array<std::uint8_t, 2 * kMaxHullEdges> loop_edges{};     // edge from that vertex to the next in its loop
  std::array<HullEdge, kMaxHullEdges> edge{};                   // in the order in which the loops first use them

  constexpr std::span<const std::uint8_t> loop(std::uint32_t face) const noexcept {
    return {loop_vertices.data() + loop_start[face], static_cast<std::size_t>(loop_start[face + 1] - loop_start[face])};
  }
  // Adds a face; false if it does not fit.
  constexpr bool add_face(std::span<const std::uint8_t> loop_of_face) noexcept {
    const std::size_t start = loop_start[faces];
    if (faces == kMaxHullFaces || loop_of_face.size() < 3 || start + loop_of_face.size() > loop_vertices.size())
      return false;
    for (std::size_t k = 0; k < loop_of_face.size(); ++k) loop_vertices[start + k] = loop_of_face[k];
    loop_start[++faces] = static_cast<std::uint16_t>(start + loop_of_face.size());
    return true;
  }
  // Finds the edges from the loops; false if the surface is not closed: an edge without exactly two faces.
  constexpr bool close() noexcept;
  friend constexpr bool operator==(const HullTopology&, const HullTopology&) noexcept = default;
};

struct Hull {
  HullTopology topology;
  // m: coordinates of the vertices, padded to whole registers with copies of the first vertex.
  alignas(32) std::array<double, kMaxHullVertices> x{}, y{}, z{};
  // Face planes n.p = offset: unit outward normals, and the largest of n.v over all vertices [m]; padded with copies of
  // face 0.
  alignas(32) std::array<double, kMaxHullFaces> nx{}, ny{}, nz{}, offsets{};
  std::array<double, kMaxHullEdges> edge_secant{};  // 1 / cos(half the angle between the normals of the edge's faces)
  double largest_secant{};                          // of edge_secant
  double inner_radius{};     // m: of the sphere about the origin that touches the nearest face plane
  double bounding_radius{};  // m: of the sphere about the origin that encloses all vertices
  double flatness{};         // m: greatest distance of a face's vertex below the face's plane
  double least_width{};      // m: smallest extent along a face normal
  Vec3d half_extents{};      // m: the box |x| <= h.x, ... about the origin encloses all vertices
  double volume{};           // m^3
  Vec3d inertia_per_kg{};    // m^2: principal moments per kg of a homogeneous body

  constexpr Vec3d vertex(std::uint32_t i) const noexcept { return {x[i], y[i], z[i]}; }
  constexpr Vec3d normal(std::uint32_t face) const noexcept { return {nx[face], ny[face], nz[face]}; }
  friend constexpr bool operator==(const Hull&, const Hull&) noexcept = default;
};

// The list to which hull shapes refer. Read only; must stay at its address as long as the worlds exist.
using Hulls = std::span<const Hull>;

enum class HullFault : std::uint32_t {
  kNone = 0,
  kNotFinite = 1,  // a coordinate is not finite
  kNotClosed = 2,  // the faces do not form a closed surface
  kFlat = 3,       // no volume
  kNotConvex = 4,  // a vertex lies outside the plane of a face by more than the tolerance
};

// Fills `hull` from vertices in any frame and the loops of `topology` (the edges are computed here), and
// `given_from_body` with the pose of the hull's frame in the frame of the vertices. Mass properties are exact for the
// polyhedron (sums over tetrahedra; moments of a tetrahedron: Tonon 2004, equations 9a to 9f).
[[nodiscard]] HullFault make_hull(std::span<const Vec3d> vertices, const HullTopology& topology, Hull& hull,
                                  Posed& given_from_body) noexcept;

constexpr bool HullTopology::close() noexcept {
  edges = 0;
  for (std::uint32_t face = 0; face < faces; ++face) {
    const auto around = loop(face);
    for (std::size_t k = 0; k < around.size(); ++k) {
      const std::uint8_t from = around[k], to = around[k + 1 == around.size() ? 0 : k + 1];
      if (from >= vertices || to >= vertices || from == to) return false;
      std::uint32_t e = 0;
      while (e < edges && !(edge[e].from == to && edge[e].to == from)) {
        if (edge[e].from == from && edge[e].to == to) return false;  // two faces with the same direction of the edge
        ++e;
      }
      if (e == kMaxHullEdges) return false;
      if (e == edges)
        edge[edges++] = {.from = from, .to = to, .left = static_cast<std::uint8_t>(face), .right = 0xff};
      else if (edge[e].right == 0xff)
        edge[e].right = static_cast<std::uint8_t>(face);
      else
        return false;
      loop_edges[loop_start[face] + k] = static_cast<std::uint8_t>(e);
    }
  }
  for (std::uint32_t e = 0; e < edges; ++e)
    if (edge[e].right == 0xff) return false;
  return vertices + faces == edges + 2;
}

}  // namespace tactus::physics
