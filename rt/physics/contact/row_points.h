// The points of a row of contacts: how a sweep solves them, one after the other, on six numbers (contact_row.h).
//
// A row R has the lanes V of its contacts: points, x, y, separation, gap, friction, w_normal, w_tangent, normal_mass,
// tangent_mass, normal_impulse, tangent_impulse, w_cross. Formulas, units and source: contact_row.h. Thread: [rt];
// pure. Bound: kMaxManifoldPoints points.
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "rt/physics/collision/manifold.h"
#include "rt/physics/contact/softness.h"
#include "rt/physics/solver_body.h"

namespace tactus::physics {

// Blocks of W: symmetric 3 x 3 in the order 00 11 22 01 02 12.
template <class V>
using SymBlock = std::array<V, 6>;

// An impulse and its moment about the plane's centre, or a change of the relative motion there, in blocks.
template <class V>
struct NormalPart {
  V n{}, m1{}, m2{};
};
template <class V>
struct TangentPart {
  V t1{}, t2{}, mn{};
};

// W of a contact, in blocks: normal, tangent, and (v_1, v_2, w_n) per (f_n, m_1, m_2), row by row.
template <class V>
struct Mobility {
  SymBlock<V> normal, tangent;
  std::array<V, 9> cross;
};

// `answer_of(p, m)`: change of the relative motion {v, w} at the plane's centre by the impulse p and the moment m
// there.
template <class V, class F>
Mobility<V> mobility_of(const Vec3<V>& n, const Vec3<V>& t1, const Vec3<V>& t2, F&& answer_of) noexcept {
  const Vec3<V> none;
  const auto by_n = answer_of(n, none), m1 = answer_of(none, t1), m2 = answer_of(none, t2);
  const auto by_1 = answer_of(t1, none), by_2 = answer_of(t2, none), mn = answer_of(none, n);
  return {{dot(by_n.v, n), dot(m1.w, t1), dot(m2.w, t2), dot(m1.v, n), dot(m2.v, n), dot(m2.w, t1)},
          {dot(by_1.v, t1), dot(by_2.v, t2), dot(mn.w, n), dot(by_2.v, t1), dot(mn.v, t1), dot(mn.v, t2)},
          {dot(by_n.v, t1), dot(m1.v, t1), dot(m2.v, t1), dot(by_n.v, t2), dot(m1.v, t2), dot(m2.v, t2), dot(by_n.w, n),
           dot(m1.w, n), dot(m2.w, n)}};
}

// J M^-1 J^T of a normal row at the point (x, y).
template <class V>
TACTUS_INLINE V normal_mobility(const SymBlock<V>& w, V x, V y) noexcept {
  return w[0] + y * y * w[1] + x * x * w[2] + V(2) * (y * w[3] - x * w[4] - x * y * w[5]);
}

// Effective mass of the tangents at the point (x, y).
template <class V>
TACTUS_INLINE V tangent_mass_at(const SymBlock<V>& k, V x, V y) noexcept {
  const V two(2);
  return tangent_mass_of(k[0] - two * y * k[4] + y * y * k[2], k[1] + two * x * k[5] + x * x * k[2],
                         k[3] + x * k[4] - y * k[5] - x * y * k[2]);
}

// What the biased sweep needs to correct an overlap at a point.
template <class V>
struct PointSoftness {
  V mass_scale, impulse_scale, bias_rate, most_push;
};

// Approach of a side that counts as at rest while it approaches: none.
struct NoApproach {};

// Solves the normal rows, point after point. Returns the impulses added; on return `v` is the relative motion after
// them. `rule`: a SweepRule. `softness_at(i)`: a PointSoftness, called in the biased sweep. `approach_at(x, y)`: the
// speed [m/s] by which the bodies count as separating faster than they do.
template <bool kBias, bool kTotals, class Row, class V, class Rule, class SoftnessAt, class ApproachAt = NoApproach>
TACTUS_INLINE NormalPart<V> solve_normals(Row& c, NormalPart<V>& v, const Rule& rule, bool backwards,
                                          SoftnessAt&& softness_at, ApproachAt&& approach_at = {}) noexcept {
  const SymBlock<V>& w = c.w_normal;
  const V zero(0), inverse_h(rule.inverse_h), slop(rule.slop);
  NormalPart<V> sum;
  for (std::uint32_t k = 0; k < c.points; ++k) {
    const std::uint32_t i = backwards ? c.points - 1 - k : k;
    const V x = c.x[i], y = c.y[i], last = c.normal_impulse[i];
    const V s = c.gap[i];
    const auto apart = s > zero;
    V mass = c.normal_mass[i];
    const V close = mass * (s * inverse_h);  // separated: may close the gap, no more
    V keep;
    if constexpr (kBias) {
      const PointSoftness<V> soft = softness_at(i);
      const auto [push, leak] =
          limited<V>({soft.bias_rate * smaller(zero, s + slop), soft.impulse_scale * last}, mass, soft.most_push);
      keep = last - select(apart, close, mass * push + leak);
      mass = select(apart, mass, mass * soft.mass_scale);
    } else {
      keep = last - select(apart, close, zero);
    }
    // Velocity change by a unit impulse at this point: W (1, y, -x).
    const V by_n = w[0] + w[3] * y - w[4] * x, by_1 = w[3] + w[1] * y - w[5] * x, by_2 = w[4] + w[5] * y - w[2] * x;
    V u = v.n + (y * v.m1 - x * v.m2);
    if constexpr (!std::is_same_v<std::remove_cvref_t<ApproachAt>, NoApproach>) u += approach_at(x, y);
    const V next = larger(zero, keep - mass * u);
    const V change = next - last;
    c.normal_impulse[i] = next;
    v.n += by_n * change;
    v.m1 += by_1 * change;
    v.m2 += by_2 * change;
    sum.n += change;
    sum.m1 += y * change;
    sum.m2 -= x * change;
    if constexpr (kTotals) c.total_normal_impulse[i] += next;
  }
  return sum;
}

// The relative motion along the tangents after the normal impulses, that before them given by its velocity `v` at the
// plane's centre and angular velocity `w`.
template <class V, class Row>
TACTUS_INLINE TangentPart<V> tangent_motion_after(const Row& c, const Vec3<V>& v, const Vec3<V>& w,
                                                  const NormalPart<V>& pressed) noexcept {
  const std::array<V, 9>& k = c.w_cross;
  return {dot(c.t1, v) + k[0] * pressed.n + k[1] * pressed.m1 + k[2] * pressed.m2,
          dot(c.t2, v) + k[3] * pressed.n + k[4] * pressed.m1 + k[5] * pressed.m2,
          dot(c.n, w) + k[6] * pressed.n + k[7] * pressed.m1 + k[8] * pressed.m2};
}

// Solves the friction rows, point after point, each within the disk of its own normal impulse.
template <bool kTotals, class Row, class V>
TACTUS_INLINE TangentPart<V> solve_friction(Row& c, TangentPart<V> v, bool backwards) noexcept {
  const SymBlock<V>& w = c.w_tangent;
  TangentPart<V> sum;
  for (std::uint32_t k = 0; k < c.points; ++k) {
    const std::uint32_t i = backwards ? c.points - 1 - k : k;
    const V x = c.x[i], y = c.y[i], mass = c.tangent_mass[i];
    const V last_1 = c.tangent_impulse[0][i], last_2 = c.tangent_impulse[1][i];
    V next_1 = last_1 - mass * (v.t1 - y * v.mn), next_2 = last_2 - mass * (v.t2 + x * v.mn);
    clamp_to_disk(next_1, next_2, c.friction * c.normal_impulse[i]);
    const V f1 = next_1 - last_1, f2 = next_2 - last_2, m = x * f2 - y * f1;
    c.tangent_impulse[0][i] = next_1;
    c.tangent_impulse[1][i] = next_2;
    v.t1 += w[0] * f1 + w[3] * f2 + w[4] * m;
    v.t2 += w[3] * f1 + w[1] * f2 + w[5] * m;
    v.mn += w[4] * f1 + w[5] * f2 + w[2] * m;
    sum.t1 += f1;
    sum.t2 += f2;
    sum.mn += m;
    if constexpr (kTotals) {
      c.total_tangent_impulse[0][i] += next_1;
      c.total_tangent_impulse[1][i] += next_2;
    }
  }
  return sum;
}

// The impulses of a row's points together, and their moment about the plane's centre.
template <class V>
struct PointSum {
  NormalPart<V> normal;
  TangentPart<V> tangent;

  Vec3<V> impulse(const Vec3<V>& n, const Vec3<V>& t1, const Vec3<V>& t2) const noexcept {
    return normal.n * n + tangent.t1 * t1 + tangent.t2 * t2;
  }
  Vec3<V> moment(const Vec3<V>& n, const Vec3<V>& t1, const Vec3<V>& t2) const noexcept {
    return normal.m1 * t1 + normal.m2 * t2 + tangent.mn * n;
  }
};

template <class V, class Row>
PointSum<V> sum_of_points(const Row& c) noexcept {
  PointSum<V> sum;
  for (std::uint32_t i = 0; i < c.points; ++i) {
    const V x = c.x[i], y = c.y[i], f = c.normal_impulse[i], f1 = c.tangent_impulse[0][i], f2 = c.tangent_impulse[1][i];
    sum.normal.n += f;
    sum.normal.m1 += y * f;
    sum.normal.m2 -= x * f;
    sum.tangent.t1 += f1;
    sum.tangent.t2 += f2;
    sum.tangent.mn += x * f2 - y * f1;
  }
  return sum;
}

}  // namespace tactus::physics
