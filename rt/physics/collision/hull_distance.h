// Are two hulls farther apart than a margin? Inside narrow phase. Thread: [any]; pure.
//
// Frame: that of the hull called `ref`. Units: m.
// Source: Gilbert, Johnson and Keerthi 1988; the closest point of a simplex: Ericson 2005, section 5.1. Each support
// point bounds the distance from below, each simplex from above, so most pairs are decided after two or three of them.
// Bound: kMaxRounds rounds, each one support point of both hulls and one simplex of at most four points.
#pragma once

#include "rt/physics/collision/hull_pair.h"

namespace tactus::physics {

struct HullSeparation {
  bool apart{false};  // true: the distance exceeds the margin
  double gap{};       // m: if apart, a lower bound of the distance that exceeds the margin
  Vec3d along;        // if apart: the direction of the gap, from ref to the other, of any length
};

// A pose that is not finite counts as not apart: the tests that follow reject it.
HullSeparation gap_of(const RelativeHulls& hulls, double margin) noexcept;

}  // namespace tactus::physics
