// The part of a box's face that lies above another box's face. Inside narrow phase; what boxes and hulls have in common
// is in clip_polygon.h. Thread: [any]; pure. Bound: a quadrilateral against four lines has at most eight corners.
//
// Frame: the reference face's own: u, v along its sides, w outward from it. Units: m.
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
  bool kept;          // among the points of the last step
};

struct ClipPolygon {
  std::uint32_t count{0};
  std::array<ClipPoint, kMaxClipPoints> points;
};

// Cuts the polygon to |u| <= half_u, |v| <= half_v. Empty where nothing is left. A point on a side, or beyond it by at
// most 10 um, stays where it is; of points within 20 um of each other one is left.
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
