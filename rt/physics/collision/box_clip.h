// Clips a box's face to the outline of another box's face. Inside narrow phase; the code shared with hulls is in
// clip_polygon.h. Thread: [any]; pure. Bound: a quadrilateral clipped by four lines has at most eight corners.
//
// Frame: that of the reference face: u, v along its sides, w outward. Units: m.
#pragma once

#include "rt/physics/collision/clip_polygon.h"

namespace tactus::physics {

inline constexpr std::uint32_t kMaxClipPoints = 8;

// Labels of the lines that bound the polygon: a box has 12 edges, a reference face 4 sides.
inline constexpr std::uint8_t kFirstSide = 12;

struct ClipPoint {
  double u, v, w;     // m
  std::uint8_t id;    // corner of the incident box 0..7, or the crossing of a line with a side 8..71
  std::uint8_t line;  // label of the line from this point to the next
  bool kept;          // was a point of the last step's manifold
};

struct ClipPolygon {
  std::uint32_t count{0};
  std::array<ClipPoint, kMaxClipPoints> points;
};

// Clips the polygon to |u| <= half_u, |v| <= half_v; empty if nothing is left. A point on a side, or beyond it by at
// most 10 um, is kept unchanged; of points within 20 um of each other one is kept.
inline void clip_to_rectangle(ClipPolygon& polygon, double half_u, double half_v) noexcept {
  const auto cut_to = [&](double ClipPoint::*coordinate, double sign, double limit, int side) noexcept {
    cut(
        polygon, [=](const ClipPoint& point) noexcept { return sign * (point.*coordinate) - limit; },
        [=](const ClipPoint& from) noexcept { return static_cast<std::uint8_t>(8 + from.line * 4 + side); },
        static_cast<std::uint8_t>(kFirstSide + side));
  };
  cut_to(&ClipPoint::u, 1.0, half_u, 0);
  cut_to(&ClipPoint::u, -1.0, half_u, 1);
  cut_to(&ClipPoint::v, 1.0, half_v, 2);
  cut_to(&ClipPoint::v, -1.0, half_v, 3);
  merge_neighbours(polygon);
}

}  // namespace tactus::physics
