// Where two shapes touch or are about to: at most four points on one normal.
//
// Frame: world; points are given from each body's centre, so that a world far from the origin loses nothing.
// Thread: [any]; pure functions of shapes and poses, bounded work (box-box: 15 axes, one clip of a quadrilateral
// against four edges, eight projections where no face looks at the other; hulls: hull_pair.h), no allocation.
// Source: separating axes, Gottschalk 1996; clipping, Sutherland and Hodgman 1974.
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "rt/physics/shapes/shape.h"

namespace tactus::physics {

inline constexpr std::uint32_t kMaxManifoldPoints = 4;

struct ManifoldPoint {
  Vec3d from_a, from_b;  // m: the contact point (midway between the surfaces) from the centre of A, of B; world axes
  double separation{};   // m: signed gap along the normal; negative where the shapes overlap
  std::uint32_t feature{0};  // which features made it: the same pair of features has the same id from step to step
};

// Of a pair of boxes or hulls: did a face make it, of A (1) or of B (2), and not two closest places (0) or edges (3)?
constexpr bool is_of_face(std::uint32_t feature) noexcept { return (feature >> 30) % 3 != 0; }

// Gaps are not known to be larger than this [m], however large they are.
inline constexpr double kLargestGap = 2e-2;

struct Manifold {
  Vec3d normal;  // unit, from A to B
  std::uint32_t count{0};
  // Between boxes that are apart: the gap along one of the axes, rounding included. As long as the centres move
  // against each other by d [m] and the bodies turn by t [rad] in all, that axis' gap stays above gap - d - lever_arm
  // t, and as long as this is more than the margin there is no point. 0 where nothing is known.
  double gap{}, lever_arm{};  // m
  std::array<ManifoldPoint, kMaxManifoldPoints> points;
};

// What narrow phase remembers of a pair from one step to the next: a hint that saves work, and a preference that
// keeps the reference face from flickering. Part of the state: it travels on the tape.
inline constexpr std::uint8_t kFirstHullAxis = 16;

struct AxisCache {
  std::uint8_t axis{0};     // 0 none; box-box: 1..6 a face axis, 7..15 an edge axis; from kFirstHullAxis: of hulls
  std::uint8_t a{0}, b{0};  // hulls: the face or the edge of A, of B; 0 otherwise
  friend bool operator==(const AxisCache&, const AxisCache&) = default;
};

// Features of the points that a pair had in the last step, any order: where there are more points than a manifold
// holds, they stay.
struct LastFeatures {
  std::uint32_t count{0};
  std::array<std::uint32_t, kMaxManifoldPoints> of{};

  constexpr bool has(std::uint32_t feature) const noexcept {
    for (std::uint32_t i = 0; i < count; ++i)
      if (of[i] == feature) return true;
    return false;
  }
};

// Fills a manifold of the points whose separation is at most `margin` [m]; count 0 where there is none, also where a
// pose is not finite. Within the margin a contact is always found, and the least separation is never larger than the
// distance; between boxes and hulls it may be smaller while they are apart corner to corner.
// `hulls`: what the indices of hull shapes refer to; one that is not there touches nothing.
// A plane may be A or B. Two planes never touch; a mesh is not touched here but patch by patch (collide_mesh.h). Ties
// are broken by the lower feature id: the same input gives the same bits, and a pair given in the other order gives the
// mirrored manifold only approximately, so callers keep A as the body with the lower id.
Manifold collide(const Shape& a, const Posed& world_from_a, const Shape& b, const Posed& world_from_b, double margin,
                 AxisCache& cache, std::type_identity_t<Hulls> hulls = {}, const LastFeatures& last = {}) noexcept;

}  // namespace tactus::physics
