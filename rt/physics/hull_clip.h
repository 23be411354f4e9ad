// The part of a hull's face that lies above another hull's face, and the four points that stand for it. Inside narrow
// phase. Thread: [any]; pure. Bound: a polygon of n corners cut by m lines has at most n + m.
//
// Frame: the reference face's own: u, v along it, w outward from it. Units: m. What is near a side, or near another
// point, is treated as between boxes (box_clip.h): noise must not change the points from step to step.
// Source: clipping by half planes, Sutherland and Hodgman 1974.
#pragma once

#include <array>
#include <cstdint>

#include "rt/physics/hull.h"

namespace tactus::physics {

inline constexpr std::uint32_t kMaxHullClipPoints = 2 * kMaxHullVertices;

template <class T>
struct HullClipPoint {
  T u, v, w;           // m
  std::uint32_t id;    // a vertex of the incident hull, or the crossing of a line with a side
  std::uint32_t line;  // the line from this point to the next: an edge of the incident hull, or a side
};

// Labels: edges of the incident hull from 0, sides (edges of the reference hull) from kFirstHullSide; a crossing has
// both, beyond the vertices.
inline constexpr std::uint32_t kFirstHullSide = 256;
inline constexpr std::uint32_t kFirstHullCrossing = 1u << 18;

template <class T>
struct HullPolygon {
  std::uint32_t count{0};
  std::array<HullClipPoint<T>, kMaxHullClipPoints> points;
};

// Keeps what has nu u + nv v <= limit, (nu, nv) of length 1; `side` is an edge of the reference hull.
template <class T>
void clip_to_side(HullPolygon<T>& polygon, T nu, T nv, T limit, std::uint32_t side) noexcept;

// Of points within 20 um of their neighbour one is left: the lower id, with the depth of the deeper.
template <class T>
void merge_neighbours(HullPolygon<T>& polygon) noexcept;

// Chooses at most four: the deepest, the farthest from it, the largest triangle, the largest quadrilateral. What is
// nearly equal goes to the lower id.
template <class T>
void reduce_to_four(HullPolygon<T>& polygon) noexcept;

}  // namespace tactus::physics
