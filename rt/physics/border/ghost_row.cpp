#include "rt/physics/border/ghost_row.h"

#include "rt/physics/border/work_limit.h"

namespace tactus::physics {
namespace {

using V = GhostRow::V;
using TwistV = Twist<V>;
using WrenchV = Wrench<V>;

// The motion of a ghost in each lane.
struct GhostLanes {
  TwistV velocity;
  Vec3<V> moved, turned;

  static constexpr int kNumbers = 12;
  static_assert(offsetof(GhostState, velocity) == 0 && offsetof(GhostState, moved) == 6 * sizeof(double) &&
                offsetof(GhostState, turned) == 9 * sizeof(double));

  TACTUS_INLINE static GhostLanes read(const GhostState* ghosts, const GhostRow::Lanes& at) noexcept {
    V x[kNumbers];
    gather_numbers<kNumbers>(ghosts, at, x);
    return {{{x[0], x[1], x[2]}, {x[3], x[4], x[5]}}, {x[6], x[7], x[8]}, {x[9], x[10], x[11]}};
  }
  TACTUS_INLINE static GhostLanes read_velocities(const GhostState* ghosts, const GhostRow::Lanes& at) noexcept {
    V x[8];
    gather_numbers<8>(ghosts, at, x);
    return {{{x[0], x[1], x[2]}, {x[3], x[4], x[5]}}, {x[6], x[7], V(0)}, {}};
  }
  // The rest of the last register, moved.x and .y, is written back unchanged.
  TACTUS_INLINE void write_velocities(GhostState* ghosts, const GhostRow::Lanes& at,
                                      std::uint32_t used) const noexcept {
    const Vec3<V>&v = velocity.linear, &w = velocity.angular;
    const V x[8] = {v.x, v.y, v.z, w.x, w.y, w.z, moved.x, moved.y};
    scatter_numbers<6>(x, ghosts, at, used);
  }
};

// Both sides of a row.
struct Sides {
  BodyLanes<V> member;
  GhostLanes ghost;

  template <bool kPoses>
  TACTUS_INLINE static Sides read(const GhostRow& row, const SolverBodies<double>& bodies,
                                  std::span<const GhostState> ghosts) noexcept {
    if constexpr (kPoses)
      return {BodyLanes<V>::read(bodies.motion.data(), row.member), GhostLanes::read(ghosts.data(), row.ghost)};
    return {BodyLanes<V>::read_velocities(bodies.motion.data(), row.member),
            GhostLanes::read_velocities(ghosts.data(), row.ghost)};
  }
  TACTUS_INLINE void write(const GhostRow& row, const SolverBodies<double>& bodies,
                           std::span<GhostState> ghosts) const noexcept {
    member.write_velocities(bodies.motion.data(), row.member, row.used);
    ghost.write_velocities(ghosts.data(), row.ghost, row.used);
  }
  // Applies the impulse `p` at the plane's centre and the moment `m` to the member, the opposite to the ghost.
  TACTUS_INLINE void apply(const GhostRow& row, const Vec3<V>& p, const Vec3<V>& m) noexcept {
    member.v += row.inverse_mass * p;
    member.w += row.inverse_inertia * (cross(row.c_member, p) + m);
    ghost.velocity -= row.admittance * WrenchV{p, cross(row.c_ghost, p) + m};
  }
};

// A point of each lane: its arm from the member's centre, and its impulse on the member.
struct PointImpulse {
  Vec3<V> arm, normal, friction;

  TACTUS_INLINE static PointImpulse of(const GhostRow& c, std::uint32_t i) noexcept {
    return {c.c_member + c.x[i] * c.t1 + c.y[i] * c.t2, c.normal_impulse[i] * c.n,
            c.tangent_impulse[0][i] * c.t1 + c.tangent_impulse[1][i] * c.t2};
  }
  TACTUS_INLINE Vec3<V> whole() const noexcept { return normal + friction; }
  TACTUS_INLINE Vec3<V> velocity(const TwistV& v) const noexcept { return v.linear + cross(v.angular, arm); }
};

TACTUS_INLINE TwistV mean_velocity(const GhostRow& c, const BodyLanes<V>& member) noexcept {
  const V half(0.5);
  return {half * (c.start_v + member.v), half * (c.start_w + member.w)};
}

// Updates the points' gaps after the bodies have moved. Of the member exact, as in contact_row.cpp.
TACTUS_INLINE void update_gaps(GhostRow& c, const Sides& sides) noexcept {
  const BodyLanes<V>& member = sides.member;
  const Vec3<V> turn = rotate_inverse(member.delta_rotation, c.n) - c.n;
  const Vec3<V> ghost_turn = cross(c.n, sides.ghost.turned);
  V gap = dot(c.n, member.delta_position - sides.ghost.moved) + dot(turn, c.c_member) - dot(ghost_turn, c.c_ghost);
  if (c.any_round) gap += c.round * dot(turn, c.n);
  const V slope_1 = dot(turn - ghost_turn, c.t1), slope_2 = dot(turn - ghost_turn, c.t2);
  for (std::uint32_t i = 0; i < c.points; ++i) c.gap[i] = c.separation[i] + gap + c.x[i] * slope_1 + c.y[i] * slope_2;
}

template <bool kBias>
TACTUS_INLINE NormalPart<V> solve_normals(GhostRow& c, const Sides& sides, NormalPart<V>& motion,
                                          const SweepRule<double>& rule, double supply) noexcept {
  const auto softness_of = [&](V mass_scale, double correction) noexcept {
    return PointSoftness<V>{mass_scale, V(1) - mass_scale, mass_scale * V(correction * rule.softness.bias_rate),
                            mass_scale * V(-rule.max_push_speed / rule.softness.mass_scale)};
  };
  if (supply == 1.0)
    return physics::solve_normals<kBias, false>(
        c, motion, rule, !kBias, [&](std::uint32_t i) noexcept { return softness_of(c.mass_scale[i], 1.0); });
  const TwistV& ghost = sides.ghost.velocity;
  const NormalPart<V> of_ghost{dot(c.n, ghost.linear + cross(ghost.angular, c.c_ghost)), dot(c.t1, ghost.angular),
                               dot(c.t2, ghost.angular)};
  const V held(1.0 - supply);
  return physics::solve_normals<kBias, false>(
      c, motion, rule, !kBias,
      [&](std::uint32_t i) noexcept {
        const V full = c.mass_scale[i];
        return softness_of(full / (full + V(supply) * (V(1) - full)), supply);
      },
      [&](V x, V y) noexcept { return held * larger(V(0), of_ghost.n + (y * of_ghost.m1 - x * of_ghost.m2)); });
}

template <bool kBias, bool kFriction>
void solve(GhostRow& c, const SolverBodies<double>& bodies, std::span<GhostState> ghosts, const SweepRule<double>& rule,
           double supply) noexcept {
  Sides sides = Sides::read<!kBias>(c, bodies, ghosts);
  if constexpr (!kBias) update_gaps(c, sides);
  const TwistV& ghost = sides.ghost.velocity;
  const Vec3<V> v = sides.member.v + cross(sides.member.w, c.c_member) -
                    (ghost.linear + cross(ghost.angular, c.c_ghost)),
                w = sides.member.w - ghost.angular;
  NormalPart<V> motion{dot(c.n, v), dot(c.t1, w), dot(c.t2, w)};
  const NormalPart<V> pressed = solve_normals<kBias>(c, sides, motion, rule, supply);
  Vec3<V> p = pressed.n * c.n, m = pressed.m1 * c.t1 + pressed.m2 * c.t2;
  if constexpr (kFriction) {
    const TangentPart<V> rubbed = solve_friction<false>(c, tangent_motion_after(c, v, w, pressed), true);
    p += rubbed.t1 * c.t1 + rubbed.t2 * c.t2;
    m += rubbed.mn * c.n;
  }
  sides.apply(c, p, m);
  sides.write(c, bodies, ghosts);
}

// Takes back so much of a point's impulse J that its work becomes `allowed`: of the friction alone, where the normal
// impulse supplies nothing, or of all of it. A lane whose work is allowed already keeps its impulse.
void take_back(GhostRow& c, std::uint32_t i, Sides& sides, V allowed, bool all) noexcept {
  const PointImpulse point = PointImpulse::of(c, i);
  const Vec3<V> whole = point.whole(), part = all ? whole : point.friction;
  const Vec3<V> mean = point.velocity(mean_velocity(c, sides.member));
  const Vec3<V> answer = c.inverse_mass * part + cross(c.inverse_inertia * cross(point.arm, part), point.arm);
  const V work = dot(whole, mean), by_normal = dot(point.normal, mean);
  const V slope = dot(part, mean) + V(0.5) * dot(whole, answer), square = dot(part, answer);
  V x(0);
  for (int lane = 0; lane < static_cast<int>(c.used); ++lane) {
    const double beyond = lane_of(work, lane) - lane_of(allowed, lane);
    if (beyond > 0.0 && (all || lane_of(by_normal, lane) <= 0.0))
      set_lane(x, lane, share_taken_back(lane_of(slope, lane), lane_of(square, lane), beyond));
  }
  const Vec3<V> taken = x * part;
  sides.apply(c, taken, cross(point.arm - c.c_member, taken));
  const V kept = V(1) + x;
  if (all) c.normal_impulse[i] *= kept;
  c.tangent_impulse[0][i] *= kept;
  c.tangent_impulse[1][i] *= kept;
}

}  // namespace

void fill_lane(GhostRow& row, int lane, const GhostContact& from, const SolverBodies<double>& bodies) noexcept {
  const auto& [points, slot, member, ghost, scale, friction] = from;
  const auto count = static_cast<std::uint32_t>(points.size());
  const BorderContact& contact = points.front();
  row.member[lane] = slot;
  row.ghost[lane] = contact.ghost;
  row.points = std::max(row.points, count);
  row.any_round |= contact.member_round > 0.0;
  set_lane(row.n, lane, contact.normal);
  set_lane(row.friction, lane, contact.friction);
  set_lane(row.round, lane, contact.member_round);
  set_lane(row.inverse_mass, lane, bodies.motion[slot].inverse_mass);
  set_lane(row.inverse_inertia, lane, bodies.inverse_inertia[slot]);
  set_lane(row.admittance.linear, lane, ghost.admittance.linear);
  set_lane(row.admittance.angular, lane, ghost.admittance.angular);
  for (int i = 0; i < 3; ++i) set_lane(row.admittance.crossed[i], lane, ghost.admittance.crossed[i]);

  Vec3d from_member[GhostRow::kPoints], c_member, c_ghost;
  for (std::uint32_t i = 0; i < count; ++i) {
    const BorderContact& c = points[i];
    from_member[i] = rotate(member.rotation, c.member_anchor) - c.member_round * c.normal;
    c_member += from_member[i];
    c_ghost += c.ghost_round > 0.0 ? c.ghost_centre + c.ghost_round * c.normal
                                   : Vec3d{member.position + from_member[i] - ghost.centre};
  }
  c_member *= 1.0 / static_cast<double>(count);
  c_ghost *= 1.0 / static_cast<double>(count);
  set_lane(row.c_member, lane, c_member);
  set_lane(row.c_ghost, lane, c_ghost);
  for (std::uint32_t i = 0; i < GhostRow::kPoints; ++i) {
    const bool there = i < count, rubs = there && friction;
    const BorderContact& c = points[there ? i : 0];
    const Vec3d place = from_member[there ? i : 0];
    // Until `complete` the totals hold the points' positions relative to the centre, `mass_scale` the outside body's
    // own part of A; an unused point has mass 0.
    set_lane(row.total_normal_impulse[i], lane, place.x - c_member.x);
    set_lane(row.total_tangent_impulse[0][i], lane, place.y - c_member.y);
    set_lane(row.total_tangent_impulse[1][i], lane, place.z - c_member.z);
    set_lane(row.mass_scale[i], lane, c.outside_inverse_mass);
    set_lane(row.normal_mass[i], lane, there ? 1.0 : 0.0);
    set_lane(row.separation[i], lane, c.gap + dot(c.normal, member.position + place - c.line_point));
    set_lane(row.normal_impulse[i], lane, there ? scale * c.normal_impulse : 0.0);
    set_lane(row.tangent_mass[i], lane, rubs ? 1.0 : 0.0);
    set_lane(row.tangent_impulse[0][i], lane, rubs ? scale * c.tangent_impulse[0] : 0.0);
    set_lane(row.tangent_impulse[1][i], lane, rubs ? scale * c.tangent_impulse[1] : 0.0);
  }
}

void complete(GhostRow& c, const Softness<double>& softness) noexcept {
  const auto [t1, t2] = tangents_of(c.n);
  c.t1 = t1;
  c.t2 = t2;
  struct Answer {
    Vec3<V> v, w;
  };
  const auto of_member = [&](const Vec3<V>& p, const Vec3<V>& m) noexcept {
    const Vec3<V> w = c.inverse_inertia * (cross(c.c_member, p) + m);
    return Answer{c.inverse_mass * p + cross(w, c.c_member), w};
  };
  const Mobility<V> w = mobility_of(c.n, c.t1, c.t2, [&](const Vec3<V>& p, const Vec3<V>& m) noexcept {
    const Answer member = of_member(p, m);
    const TwistV ghost = c.admittance * WrenchV{p, cross(c.c_ghost, p) + m};
    return Answer{member.v + ghost.linear + cross(ghost.angular, c.c_ghost), member.w + ghost.angular};
  });
  c.w_normal = w.normal;
  c.w_tangent = w.tangent;
  c.w_cross = w.cross;
  const SymBlock<V> member = mobility_of(c.n, c.t1, c.t2, of_member).normal;
  const V zero(0), a2_inverse(softness.impulse_scale / softness.mass_scale);
  c.member_share = zero;
  for (std::uint32_t i = 0; i < c.points; ++i) {
    const Vec3<V> place{c.total_normal_impulse[i], c.total_tangent_impulse[0][i], c.total_tangent_impulse[1][i]};
    const V x = dot(place, c.t1), y = dot(place, c.t2);
    const V alone = normal_mobility(member, x, y);
    c.x[i] = x;
    c.y[i] = y;
    c.gap[i] = c.separation[i];
    c.normal_mass[i] *= invert_or_zero(normal_mobility(c.w_normal, x, y));
    c.tangent_mass[i] *= tangent_mass_at(c.w_tangent, x, y);
    c.mass_scale[i] = V(1) / (V(1) + (alone + c.mass_scale[i]) * c.normal_mass[i] * a2_inverse);
    c.member_share = larger(c.member_share, alone * c.normal_mass[i]);
    c.total_normal_impulse[i] = c.total_tangent_impulse[0][i] = c.total_tangent_impulse[1][i] = c.work[i] = zero;
  }
}

void begin_sub_step(GhostRow& c, const SolverBodies<double>& bodies) noexcept {
  const auto member = BodyLanes<V>::read_velocities(bodies.motion.data(), c.member);
  c.start_v = member.v;
  c.start_w = member.w;
}

void warm_start(GhostRow& c, const SolverBodies<double>& bodies, std::span<GhostState> ghosts) noexcept {
  for (std::uint32_t i = 0; i < c.points; ++i)
    clamp_to_disk(c.tangent_impulse[0][i], c.tangent_impulse[1][i], c.friction * c.normal_impulse[i]);
  const PointSum<V> sum = sum_of_points<V>(c);
  Sides sides = Sides::read<false>(c, bodies, ghosts);
  sides.apply(c, sum.impulse(c.n, c.t1, c.t2), sum.moment(c.n, c.t1, c.t2));
  sides.write(c, bodies, ghosts);
}

void solve_biased(GhostRow& row, const SolverBodies<double>& bodies, std::span<GhostState> ghosts,
                  const SweepRule<double>& rule, double supply) noexcept {
  solve<true, false>(row, bodies, ghosts, rule, supply);
}

void relax(GhostRow& row, const SolverBodies<double>& bodies, std::span<GhostState> ghosts,
           const SweepRule<double>& rule, double supply, bool friction) noexcept {
  friction ? solve<false, true>(row, bodies, ghosts, rule, supply)
           : solve<false, false>(row, bodies, ghosts, rule, supply);
}

void find_work(GhostRow& c, const SolverBodies<double>& bodies) noexcept {
  const TwistV mean = mean_velocity(c, BodyLanes<V>::read_velocities(bodies.motion.data(), c.member));
  for (std::uint32_t i = 0; i < c.points; ++i) {
    const PointImpulse point = PointImpulse::of(c, i);
    c.sub_step_work[i] = dot(point.whole(), point.velocity(mean));
  }
}

void keep_share(GhostRow& c, const SolverBodies<double>& bodies, std::span<GhostState> ghosts, double share) noexcept {
  Sides sides = Sides::read<false>(c, bodies, ghosts);
  for (std::uint32_t i = 0; i < c.points; ++i) {
    const PointImpulse point = PointImpulse::of(c, i);
    const V work = dot(point.whole(), point.velocity(mean_velocity(c, sides.member)));
    const V allowed = select(work > V(0), V(share) * work, work);
    take_back(c, i, sides, allowed, false);
    take_back(c, i, sides, allowed, true);
  }
  sides.write(c, bodies, ghosts);
}

void scale_impulses(GhostRow& c, double factor) noexcept {
  for (std::uint32_t i = 0; i < c.points; ++i) {
    c.normal_impulse[i] *= V(factor);
    c.tangent_impulse[0][i] *= V(factor);
    c.tangent_impulse[1][i] *= V(factor);
  }
}

void end_sub_step(GhostRow& c, std::span<GhostState> ghosts) noexcept {
  for (std::uint32_t i = 0; i < c.points; ++i) {
    c.total_normal_impulse[i] += c.normal_impulse[i];
    c.total_tangent_impulse[0][i] += c.tangent_impulse[0][i];
    c.total_tangent_impulse[1][i] += c.tangent_impulse[1][i];
    c.work[i] += c.sub_step_work[i];
  }
  const PointSum<V> sum = sum_of_points<V>(c);
  const Vec3<V> p = sum.impulse(c.n, c.t1, c.t2);
  const Vec3<V> torque = cross(c.c_ghost, p) + sum.moment(c.n, c.t1, c.t2);
  for (std::uint32_t lane = 0; lane < c.used; ++lane)
    ghosts[c.ghost[lane]].impulse -=
        Wrenchd{lane_of(p, static_cast<int>(lane)), lane_of(torque, static_cast<int>(lane))};
}

void store_impulses(const GhostRow& c, int lane, double share, std::span<BorderContact> points) noexcept {
  const auto blend = [&](double& to, const V& lanes) noexcept { store_impulse(to, lane_of(lanes, lane), share); };
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    BorderContact& to = points[i];
    blend(to.normal_impulse, c.normal_impulse[i]);
    for (int d = 0; d < 2; ++d) blend(to.tangent_impulse[d], c.tangent_impulse[d][i]);
  }
}

void store_totals(const GhostRow& c, int lane, std::span<BorderContact> points) noexcept {
  const Vec3d t1 = lane_of(c.t1, lane), t2 = lane_of(c.t2, lane);
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    BorderContact& to = points[i];
    to.step_normal_impulse = lane_of(c.total_normal_impulse[i], lane);
    to.step_tangent_impulse =
        lane_of(c.total_tangent_impulse[0][i], lane) * t1 + lane_of(c.total_tangent_impulse[1][i], lane) * t2;
    to.total_normal_impulse += to.step_normal_impulse;
    to.total_tangent_impulse += to.step_tangent_impulse;
    to.work += lane_of(c.work[i], lane);
    to.gap = lane_of(c.gap[i], lane);
  }
}

}  // namespace tactus::physics
