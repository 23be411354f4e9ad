// The part of a box's face that lies above another box's face, and the four points that stand for it. Inside narrow
// phase. Thread: [any]; pure. Bound: a quadrilateral against four lines has at most eight corners.
//
// Frame: the reference face's own: u, v along its sides, w outward from it. Units: m.
// Source: clipping by half planes, Sutherland and Hodgman 1974.
#pragma once

#include <array>
#include <cstdint>

namespace tactus::physics {

inline constexpr std::uint32_t kMaxClipPoints = 8;

// Labels of the lines that bound the polygon: a box has 12 edges, a reference face 4 sides.
inline constexpr std::uint8_t kFirstSide = 12;

template <class T>
struct ClipPoint {
  T u, v, w;          // m
  std::uint8_t id;    // corner of the incident box 0..7, or the crossing of a line with a side 8..71
  std::uint8_t line;  // label of the line from this point to the next
};

template <class T>
struct ClipPolygon {
  std::uint32_t count{0};
  std::array<ClipPoint<T>, kMaxClipPoints> points;
};

// Cuts the polygon to |u| <= half_u, |v| <= half_v. Empty where nothing is left. A point on a side, or
// beyond it by at most 10 um, stays where it is; of points within 20 um of each other one is left.
template <class T>
void clip_to_rectangle(ClipPolygon<T>& polygon, T half_u, T half_v) noexcept;

// Chooses at most four: the deepest, the farthest from it, the largest triangle, the largest quadrilateral. What is
// nearly equal goes to the lower id, so that noise does not change the choice from step to step.
template <class T>
void reduce_to_four(ClipPolygon<T>& polygon) noexcept;

}  // namespace tactus::physics
