// Clips a hull's face to the outline of another hull's face. Inside narrow phase; the code shared with boxes is in
// clip_polygon.h. Thread: [any]; pure. Bound: a polygon of n corners clipped by m lines has at most n + m.
//
// Frame: that of the reference face: u, v along it, w outward. Units: m.
#pragma once

#include "rt/physics/collision/clip_polygon.h"
#include "rt/physics/shapes/hull.h"

namespace tactus::physics {

inline constexpr std::uint32_t kMaxHullClipPoints = 2 * kMaxHullVertices;

struct HullClipPoint {
  double u, v, w;      // m
  std::uint32_t id;    // a vertex of the incident hull, or the crossing of a line with a side
  std::uint32_t line;  // the line from this point to the next: an edge of the incident hull, or a side
  bool kept;           // was a point of the last step's manifold
};

// Labels: edges of the incident hull from 0, sides (edges of the reference hull) from kFirstHullSide. The id of a
// crossing combines both and is above the ids of vertices.
inline constexpr std::uint32_t kFirstHullSide = 256;
inline constexpr std::uint32_t kFirstHullCrossing = 1u << 18;

struct HullPolygon {
  std::uint32_t count{0};
  std::array<HullClipPoint, kMaxHullClipPoints> points;
};

// Clips to nu u + nv v <= limit, (nu, nv) of length 1; `side`: an edge of the reference hull.
inline void clip_to_side(HullPolygon& polygon, double nu, double nv, double limit, std::uint32_t side) noexcept {
  cut(
      polygon, [=](const HullClipPoint& point) noexcept { return nu * point.u + nv * point.v - limit; },
      [=](const HullClipPoint& from) noexcept { return kFirstHullCrossing + from.line * 256u + side; },
      kFirstHullSide + side);
}

}  // namespace tactus::physics
