// The separating axes of two boxes: gaps along the 15 axes, for one pair (V = double) or one pair a lane, with the same
// bits.
//
// Inside narrow phase. Frame: world axes, origin at the centre of A. Units: m. Thread: [any]; pure, bounded.
// Source: separating axes of boxes, Gottschalk 1996.
#pragma once

#include <limits>

#include "rt/base/math.h"
#include "rt/base/wide.h"
#include "rt/physics/collision/collide.h"

namespace tactus::physics {

// Axis codes, as in AxisCache: 0 none, 1..3 faces of A, 4..6 faces of B, 7..15 edge of A x edge of B.
inline constexpr int kFirstFaceB = 4, kFirstEdge = 7;

// The axes of a body in the world, and its half extents [m].
template <class V>
struct BoxFrame {
  Vec3<V> axis[3], half;
};

template <class V>
struct BoxAxes {
  Vec3<V> axis_a[3], axis_b[3];  // of the bodies, in the world
  Vec3<V> b_from_a;              // m, from the centre of A to that of B
  V h[6];                        // m, half extents of A, of B
  V d_a[3], d_b[3];              // m, b_from_a in A's axes, in B's axes
  V r[3][3];                     // r[i][j] = axis_a[i] . axis_b[j]
};

template <class V>
TACTUS_INLINE BoxAxes<V> box_axes(const BoxFrame<V>& a, const BoxFrame<V>& b, const Vec3<V>& b_from_a) noexcept {
  const auto &p = a.axis, &q = b.axis;
  return {.axis_a = {p[0], p[1], p[2]},
          .axis_b = {q[0], q[1], q[2]},
          .b_from_a = b_from_a,
          .h = {a.half.x, a.half.y, a.half.z, b.half.x, b.half.y, b.half.z},
          .d_a = {dot(p[0], b_from_a), dot(p[1], b_from_a), dot(p[2], b_from_a)},
          .d_b = {dot(q[0], b_from_a), dot(q[1], b_from_a), dot(q[2], b_from_a)},
          .r = {{dot(p[0], q[0]), dot(p[0], q[1]), dot(p[0], q[2])},
                {dot(p[1], q[0]), dot(p[1], q[1]), dot(p[1], q[2])},
                {dot(p[2], q[0]), dot(p[2], q[1]), dot(p[2], q[2])}}};
}

// Results for the 15 axes; codes are whole numbers. `apart`: an axis whose gap exceeds the margin, or 0. If set, `gap`
// is its gap and `sine` the sine of the angle between its two edges, 1 for a face axis.
template <class V, class Code>
struct AxisTestOf {
  Code apart{0};
  V gap{}, sine{1};
  V face[6]{};     // by code - 1
  Code widest{1};  // code of the best face
  Code edge{0};    // best edge axis, or 0
  V edge_separation{};
};
using AxisTest = AxisTestOf<double, int>;

// Tests the faces' axes, and the edges' of the lanes that no face separates. Of several faces beyond the margin `apart`
// is the one with the widest gap, which stays valid longest; the lower code on a tie. A NaN counts as apart.
template <class V>
TACTUS_INLINE AxisTestOf<V, V> test_axes(const BoxAxes<V>& b, V margin) noexcept {
  using std::abs;
  using std::sqrt;
  AxisTestOf<V, V> test;
  V abs_r[3][3];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) abs_r[i][j] = abs(b.r[i][j]);
  for (int i = 0; i < 3; ++i) {
    test.face[i] = abs(b.d_a[i]) - b.h[i] - (abs_r[i][0] * b.h[3] + abs_r[i][1] * b.h[4] + abs_r[i][2] * b.h[5]);
    test.face[3 + i] =
        abs(b.d_b[i]) - b.h[3 + i] - (abs_r[0][i] * b.h[0] + abs_r[1][i] * b.h[1] + abs_r[2][i] * b.h[2]);
  }
  test.gap = test.face[0];
  auto open = test.face[0] <= margin;  // no axis separates the pair so far
  for (int k = 1; k < 6; ++k) {
    open = both(open, test.face[k] <= margin);
    const auto wider = test.face[k] > test.gap;
    test.gap = select(wider, test.face[k], test.gap);
    test.widest = select(wider, V(1 + k), test.widest);
  }
  test.apart = select(open, V(0), test.widest);
  test.edge_separation = V(-std::numeric_limits<LaneOf<V>>::infinity());
  for (int i = 0; i < 3; ++i) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    for (int j = 0; j < 3; ++j) {
      const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      if (!any(open)) return test;
      const V sine_squared = b.r[i1][j] * b.r[i1][j] + b.r[i2][j] * b.r[i2][j];
      const auto tested = both(open, sine_squared > V(kParallelSineSquared));
      if (!any(tested)) continue;
      const V extent =
          b.h[i1] * abs_r[i2][j] + b.h[i2] * abs_r[i1][j] + b.h[3 + j1] * abs_r[i][j2] + b.h[3 + j2] * abs_r[i][j1];
      const V sine = sqrt(sine_squared);
      const V separation = (abs(b.d_a[i2] * b.r[i1][j] - b.d_a[i1] * b.r[i2][j]) - extent) / sine;
      const V code(kFirstEdge + 3 * i + j);
      const auto parts = both(tested, separation > margin);
      test.apart = select(parts, code, test.apart);
      test.gap = select(parts, separation, test.gap);
      test.sine = select(parts, sine, test.sine);
      open = both(open, test.apart < V(1));
      const auto better = both(tested, separation > test.edge_separation);
      test.edge = select(better, code, test.edge);
      test.edge_separation = select(better, separation, test.edge_separation);
    }
  }
  return test;
}

// How long a gap stays valid (manifold.h); zero if it does not.
template <class V>
struct GapBound {
  V gap{}, lever_arm{};  // m
};

// The gap along the unit vector n is
//   |n.d| - sum h |a.n| - sum h |b.n|:
// it changes by at most |d| + |h_a| + |h_b| per change of n, and by |h| per angle of a box. A face's n rotates with its
// box; an edge axis, w / |w| with w = a x b, changes by at most 2 / sine of the angle. The gap is limited to a quarter
// of the size: until it is used up |d| has grown by at most that, and the edges rotate by too little to become
// parallel.
template <class V>
TACTUS_INLINE GapBound<V> bound_gap(const BoxAxes<V>& boxes, const AxisTestOf<V, V>& test) noexcept {
  const V rounding(64.0 * std::numeric_limits<double>::epsilon());
  const auto& h = boxes.h;
  const V size = norm(boxes.b_from_a) + norm(Vec3<V>{h[0], h[1], h[2]}) + norm(Vec3<V>{h[3], h[4], h[5]});
  const auto valid = both(test.gap > V(0), test.sine > V(0.1));
  const V gap = smaller(smaller(test.gap, V(0.25) * size), V(kLargestGap)) - rounding * size / test.sine;
  const V lever_arm = V(1.25) * size * select(test.apart < V(kFirstEdge), V(1), V(3) / test.sine);
  return {select(valid, gap, V(0)), select(valid, lever_arm, V(0))};
}

// The pair of one lane.
template <class V>
TACTUS_INLINE BoxAxes<double> pair_of_lane(const BoxAxes<V>& from, int lane) noexcept {
  const auto number = [lane](const V& v) noexcept { return lane_of(v, lane); };
  const auto vec = [number](const Vec3<V>& v) noexcept { return Vec3d{number(v.x), number(v.y), number(v.z)}; };
  const auto& h = from.h;
  const auto &d = from.d_a, &e = from.d_b;
  const auto& r = from.r;
  return {.axis_a = {vec(from.axis_a[0]), vec(from.axis_a[1]), vec(from.axis_a[2])},
          .axis_b = {vec(from.axis_b[0]), vec(from.axis_b[1]), vec(from.axis_b[2])},
          .b_from_a = vec(from.b_from_a),
          .h = {number(h[0]), number(h[1]), number(h[2]), number(h[3]), number(h[4]), number(h[5])},
          .d_a = {number(d[0]), number(d[1]), number(d[2])},
          .d_b = {number(e[0]), number(e[1]), number(e[2])},
          .r = {{number(r[0][0]), number(r[0][1]), number(r[0][2])},
                {number(r[1][0]), number(r[1][1]), number(r[1][2])},
                {number(r[2][0]), number(r[2][1]), number(r[2][2])}}};
}

template <class V>
TACTUS_INLINE AxisTest pair_of_lane(const AxisTestOf<V, V>& from, int lane) noexcept {
  AxisTest out{.apart = static_cast<int>(lane_of(from.apart, lane)),
               .gap = lane_of(from.gap, lane),
               .sine = lane_of(from.sine, lane),
               .face = {},
               .widest = static_cast<int>(lane_of(from.widest, lane)),
               .edge = static_cast<int>(lane_of(from.edge, lane)),
               .edge_separation = lane_of(from.edge_separation, lane)};
  for (int k = 0; k < 6; ++k) out.face[k] = lane_of(from.face[k], lane);
  return out;
}

}  // namespace tactus::physics
