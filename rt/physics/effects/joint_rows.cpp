// Solves the rows of joints, sub-step by sub-step.
#include <algorithm>

#include "rt/physics/effects/joints.h"

namespace tactus::physics {
namespace {

// The directions of the joint's axes that a kind locks.
struct Locks {
  std::array<bool, 3> linear, angular;
};
constexpr Locks kLocks[] = {{{true, true, true}, {true, true, true}},         // fixed
                            {{true, true, true}, {false, false, false}},      // ball
                            {{true, true, true}, {true, true, false}},        // hinge
                            {{true, true, false}, {true, true, true}},        // slider
                            {{false, false, false}, {false, false, false}}};  // distance
constexpr Locks locks_of(JointKind kind) noexcept { return kLocks[static_cast<std::uint32_t>(kind)]; }

Vec3d masked(const Vec3d& v, const std::array<bool, 3>& mask) noexcept {
  return {mask[0] ? v.x : 0.0, mask[1] ? v.y : 0.0, mask[2] ? v.z : 0.0};
}
Vec3d into(const Axes& axes, const Vec3d& v) noexcept { return {dot(axes.x, v), dot(axes.y, v), dot(axes.z, v)}; }
Vec3d out_of(const Axes& axes, const Vec3d& v) noexcept { return v.x * axes.x + v.y * axes.y + v.z * axes.z; }

// The inverse of J M^-1 J^T; `entry(p, q)` of axes p and q. A free direction gets a unit row and column, decoupled from
// the others.
template <class F>
SymMat3d mass_of(const Axes& axes, const std::array<bool, 3>& mask, F&& entry) noexcept {
  const Vec3d* d[] = {&axes.x, &axes.y, &axes.z};
  const auto at = [&](int p, int q) noexcept {
    const bool both = mask[static_cast<std::size_t>(p)] && mask[static_cast<std::size_t>(q)];
    return both ? entry(*d[p], *d[q]) : (p == q ? 1.0 : 0.0);
  };
  return inverse(SymMat3d{at(0, 0), at(1, 1), at(2, 2), at(0, 1), at(0, 2), at(1, 2)});
}

// J M^-1 J^T itself, zero in free directions.
template <class F>
SymMat3d matrix_of(const Axes& axes, const std::array<bool, 3>& mask, F&& entry) noexcept {
  const Vec3d* d[] = {&axes.x, &axes.y, &axes.z};
  const auto at = [&](int p, int q) noexcept {
    const bool both = mask[static_cast<std::size_t>(p)] && mask[static_cast<std::size_t>(q)];
    return both ? entry(*d[p], *d[q]) : 0.0;
  };
  return {at(0, 0), at(1, 1), at(2, 2), at(0, 1), at(0, 2), at(1, 2)};
}

// asin(x) for small x, to x^7.
double small_asin(double x) noexcept {
  const double x2 = x * x;
  return x * (1.0 + x2 * ((1.0 / 6) + x2 * ((3.0 / 40) + x2 * (15.0 / 336))));
}

// The angle with that sine and cosine (up to a common positive factor), in (-pi, pi]: two corrections of a guess, with
// our own sine, because the bits must not depend on a library. The error after the first is below 3e-4, after the
// second 1e-28.
double angle_of(double s, double c) noexcept {
  const double length = std::sqrt(s * s + c * c);
  if (!(length > 0.0)) return 0.0;
  s /= length;
  c /= length;
  constexpr double eighth = 0.78539816339744830962;
  const double a = std::abs(s), b = std::abs(c);
  // Nearest of 0, 45, 90 degrees, then by the signs to the whole circle.
  double guess = a < 0.41421356237309504880 * b ? 0.0 : (b < 0.41421356237309504880 * a ? 2.0 * eighth : eighth);
  if (c < 0.0) guess = 4.0 * eighth - guess;
  if (s < 0.0) guess = -guess;
  for (int i = 0; i < 2; ++i) {
    const auto [sine, cosine] = sin_cos(guess);
    guess += small_asin(s * cosine - c * sine);
  }
  return guess;
}

}  // namespace

Joints::Side Joints::side(StageContext& c, Row& row, std::uint32_t slot) noexcept {
  static constexpr SymMat3d kNone{};
  if (slot != kOutside) return {c.motion[slot], c.inverse_inertia[slot]};
  if (row.ghost == kNoGhost) return {row.outside, kNone};
  GhostState& ghost = c.ghosts[row.ghost];
  const Twistd seen = c.ghosts_may_supply ? ghost.velocity : Twistd{};
  row.outside.v = seen.linear;
  row.outside.w = seen.angular;
  return {row.outside, kNone, &ghost};
}

// Applies the impulse p at r [m, from the centre] and the angular impulse m to the body.
void Joints::push(const Side& side, const Vec3d& r, const Vec3d& p, const Vec3d& m) noexcept {
  const Vec3d angular_impulse = cross(r, p) + m;
  if (side.ghost != nullptr) {
    const Twistd change = side.ghost->admittance * Wrenchd{p, angular_impulse};
    side.ghost->velocity += change;
    side.body.v += change.linear;
    side.body.w += change.angular;
    return;
  }
  side.body.v += side.body.inverse_mass * p;
  side.body.w += side.inverse_inertia * angular_impulse;
}

// Change of velocity along p at r per unit impulse along q at r.
double Joints::answer(const Side& side, const Vec3d& r, const Vec3d& p, const Vec3d& q) noexcept {
  if (side.ghost == nullptr) return inverse_effective_mass(side.body.inverse_mass, side.inverse_inertia, r, p, q);
  const Twistd change = side.ghost->admittance * Wrenchd{q, cross(r, q)};
  return dot(p, change.linear + cross(change.angular, r));
}

void Joints::prepare(StageContext& c) noexcept {
  for (Row& row : rows_) {
    row.outside = {};
    row.outside.v = row.outside_motion.velocity.linear;
    row.outside.w = row.outside_motion.velocity.angular;
    row.now = row.kept = c.h * states_[row.joint].effort;
    row.sum_force = row.sum_torque = {};
  }
}

// Updates axes, lever arms, errors and the coordinate to the bodies' present poses.
void Joints::measure(Row& row, const SolverBody<double>& a, const SolverBody<double>& b) const noexcept {
  const Joint& joint = joints_[row.joint];
  const Vec3d r_a = rotate(a.delta_rotation, row.arm_a);
  row.r_b = rotate(b.delta_rotation, row.arm_b);
  const Vec3d d = row.apart + (b.delta_position - a.delta_position) + (row.r_b - row.arm_b) - (r_a - row.arm_a);
  row.r_a = r_a + d;  // both forces act at B's frame: then the rows act exactly on the velocity of their errors
  const Quatd q_a = a.delta_rotation * row.frame_a, q_b = b.delta_rotation * row.frame_b;
  row.axes = axes_of(q_a);
  row.linear_error = masked(into(row.axes, d), locks_of(joint.kind).linear);
  row.axis = row.axes.z;
  switch (joint.kind) {
    case JointKind::kHinge: {
      const Vec3d z_b = rotate(q_b, Vec3d{0.0, 0.0, 1.0});
      row.angular_error = masked(into(row.axes, cross(row.axes.z, z_b)), locks_of(joint.kind).angular);
      const Quatd turn = conjugate(q_a) * q_b;
      const double sign = turn.w < 0.0 ? -1.0 : 1.0;
      row.coordinate = 2.0 * angle_of(sign * turn.z, sign * turn.w);
      break;
    }
    case JointKind::kDistance:
      row.coordinate = norm(d);
      row.axis = normalized_or(d, row.axes.z);
      break;
    default:
      row.angular_error = masked(small_rotation_vector(conjugate(q_a) * q_b), locks_of(joint.kind).angular);
      row.coordinate = dot(row.axes.z, d);
  }
}

void Joints::fill_masses(Row& row, const Side& a, const Side& b) const noexcept {
  const JointKind kind = joints_[row.joint].kind;
  const auto linear = [&](const Vec3d& p, const Vec3d& q) noexcept {
    return answer(a, row.r_a, p, q) + answer(b, row.r_b, p, q);
  };
  const auto angular_response_of = [](const Side& side) noexcept {
    return side.ghost != nullptr ? side.ghost->admittance.angular : side.inverse_inertia;
  };
  const SymMat3d angular_response = angular_response_of(a) + angular_response_of(b);
  const auto angular = [&](const Vec3d& p, const Vec3d& q) noexcept { return dot(angular_response * p, q); };
  row.linear_mass = mass_of(row.axes, locks_of(kind).linear, linear);
  row.angular_mass = mass_of(row.axes, locks_of(kind).angular, angular);
  row.axis_mass = invert_or_zero(kind == JointKind::kHinge ? angular(row.axis, row.axis) : linear(row.axis, row.axis));
}

// Sets the own mass to infinite if the ghost has no admittance, as that of a kinematic body.
void Joints::take_own_mass(Row& row, const StageContext& c) const noexcept {
  const SymMat3d& w = c.ghosts[row.ghost].admittance.linear;
  if (w.xx + w.yy + w.zz > 0.0) return;
  row.own_inverse_mass = 0.0;
  row.own_inverse_inertia = {};
}

// Fills the masses of the biased sweep against a ghost, with the stiffness of the two bodies alone (joints.h).
void Joints::fill_give(Row& row, const Side& a, const Side& b, const Softness<double>& softness) const noexcept {
  const JointKind kind = joints_[row.joint].kind;
  const Locks& locks = kLocks[static_cast<std::uint32_t>(kind)];
  const double give = softness.impulse_scale / softness.mass_scale;  // 1 / a2
  const auto own = [&](const Side& side, const Vec3d& r, const Vec3d& p, const Vec3d& q) noexcept {
    return side.ghost != nullptr ? inverse_effective_mass(row.own_inverse_mass, row.own_inverse_inertia, r, p, q)
                                 : answer(side, r, p, q);
  };
  const auto linear = [&](const Vec3d& p, const Vec3d& q) noexcept {
    return give * (own(a, row.r_a, p, q) + own(b, row.r_b, p, q));
  };
  const auto both = [&](const Vec3d& p, const Vec3d& q) noexcept {
    return answer(a, row.r_a, p, q) + answer(b, row.r_b, p, q) + linear(p, q);
  };
  const auto angular_response_of = [](const Side& side) noexcept {
    return side.ghost != nullptr ? side.ghost->admittance.angular : side.inverse_inertia;
  };
  const auto own_angular_response_of = [&](const Side& side) noexcept {
    return side.ghost != nullptr ? row.own_inverse_inertia : side.inverse_inertia;
  };
  const SymMat3d angular_response = angular_response_of(a) + angular_response_of(b),
                 own_angular_response = own_angular_response_of(a) + own_angular_response_of(b);
  const auto angular = [&](const Vec3d& p, const Vec3d& q) noexcept { return give * dot(own_angular_response * p, q); };
  const auto both_angular = [&](const Vec3d& p, const Vec3d& q) noexcept {
    return dot(angular_response * p, q) + angular(p, q);
  };
  row.linear_soft_mass = mass_of(row.axes, locks.linear, both);
  row.angular_soft_mass = mass_of(row.axes, locks.angular, both_angular);
  row.linear_give = matrix_of(row.axes, locks.linear, linear);
  row.angular_give = matrix_of(row.axes, locks.angular, angular);
  const bool turns = kind == JointKind::kHinge;
  row.axis_give = turns ? angular(row.axis, row.axis) : linear(row.axis, row.axis);
  row.axis_soft_mass = invert_or_zero(turns ? both_angular(row.axis, row.axis) : both(row.axis, row.axis));
}

// Updates the world inertia of a fast rotating body, which changes within the step: with that of the start of the step,
// a joint's force adds rotational energy (a top at 100 rad/s gained 0.2 % of its energy in 4 s).
void turn_inertia(const StageContext& c, std::uint32_t slot) noexcept {
  const SolverBody<double>& state = c.motion[slot];
  if (state.gyroscopic == 0.0 || state.inverse_mass == 0.0) return;
  const Body& body = c.bodies[slot];
  c.inverse_inertia[slot] = rotate_diagonal(state.delta_rotation * body.motion.pose.rotation,
                                            Vec3d{1.0 / body.inertia.x, 1.0 / body.inertia.y, 1.0 / body.inertia.z});
}

void Joints::begin_sub_step(StageContext& c) noexcept {
  const double elapsed = static_cast<double>(c.sub_step) * c.h;
  for (Row& row : rows_) {
    if (c.sub_step > 0) add_to_sums(c, row);
    if (c.sub_step == 0 && row.anchored) {
      row.ghost = find_ghost(c.ghosts, outside_of(row.joint, c.bodies));
      if (row.ghost != kNoGhost) take_own_mass(row, c);
    }
    if (row.ghost != kNoGhost) {
      row.outside.delta_position = c.ghosts[row.ghost].moved;
      row.outside.delta_rotation = quat_from_rotation_vector(c.ghosts[row.ghost].turned);
    } else if (row.slot_a == kOutside || row.slot_b == kOutside) {
      row.outside.delta_position = elapsed * row.outside.v;
      row.outside.delta_rotation = quat_from_rotation_vector(elapsed * row.outside.w);
    }
    for (const std::uint32_t slot : {row.slot_a, row.slot_b})
      if (slot != kOutside && c.sub_step > 0) turn_inertia(c, slot);
    const Side a = side(c, row, row.slot_a), b = side(c, row, row.slot_b);
    measure(row, a.body, b.body);
    fill_masses(row, a, b);
    if (row.ghost != kNoGhost) fill_give(row, a, b, c.rule.softness);
    if (row.anchored) row.start_velocity = frame_velocity(c, row);
  }
}

// Velocity of the joint's frame on the side in this world, of a joint with a body of another world.
Twistd Joints::frame_velocity(const StageContext& c, const Row& row) const noexcept {
  const bool is_a = row.slot_a != kOutside;
  const SolverBody<double>& body = c.motion[is_a ? row.slot_a : row.slot_b];
  return {velocity_at(body, is_a ? row.r_a : row.r_b), body.w};
}

// Applies `effort` to B, the opposite to A.
void Joints::apply(const Row& row, const Side& a, const Side& b, const JointEffort& effort) const noexcept {
  Vec3d p = out_of(row.axes, effort.linear), m = out_of(row.axes, effort.angular);
  const double along = effort.drive + effort.lower + effort.upper;
  (joints_[row.joint].kind == JointKind::kHinge ? m : p) += along * row.axis;
  push(a, row.r_a, -p, -m);
  push(b, row.r_b, p, m);
}

Wrenchd Joints::impulse_on_b(const Row& row) const noexcept {
  const Vec3d along = (row.now.drive + row.now.lower + row.now.upper) * row.axis;
  const bool turns = joints_[row.joint].kind == JointKind::kHinge;
  return {out_of(row.axes, row.now.linear) + (turns ? Vec3d{} : along),
          out_of(row.axes, row.now.angular) + (turns ? along : Vec3d{})};
}

// J, in this sub-step, of a joint with a body of another world.
double Joints::work_on_member(const StageContext& c, const Row& row) const noexcept {
  const auto [force, torque] = impulse_on_b(row);
  const Twistd mean = 0.5 * (row.start_velocity + frame_velocity(c, row));
  const double on_b = dot(force, mean.linear) + dot(torque, mean.angular);
  return row.slot_b != kOutside ? on_b : -on_b;
}

void Joints::add_to_sums(StageContext& c, Row& row) const noexcept {
  const auto [force, torque] = impulse_on_b(row);
  row.sum_force += force;
  row.sum_torque += torque;
  if (row.ghost != kNoGhost) {
    const bool on_b = row.slot_b == kOutside;
    const Wrenchd on_outside = (on_b ? 1.0 : -1.0) * Wrenchd{force, cross(on_b ? row.r_b : row.r_a, force) + torque};
    c.ghosts[row.ghost].impulse += on_outside;
  }
  if (row.anchored) c.report.border_joints_J += work_on_member(c, row);
}

// All of the impulse counts as the part of work_limit.h.
void Joints::take_back_work(StageContext& c, Row& row, double allowed_J) noexcept {
  const double beyond = work_on_member(c, row) - allowed_J;
  const Side a = side(c, row, row.slot_a), b = side(c, row, row.slot_b);
  const bool on_b = row.slot_b != kOutside;
  const Side& member = on_b ? b : a;
  const auto [force, torque] = impulse_on_b(row);
  const Vec3d turn = cross(on_b ? row.r_b : row.r_a, force) + torque;
  const double square =
      member.body.inverse_mass * dot(force, force) + dot(turn, member.inverse_inertia * turn);  // J A J
  const double share = share_taken_back(beyond + allowed_J + 0.5 * square, square, beyond);
  apply(row, a, b, share * row.now);
  row.now = (1.0 + share) * row.now;
}

Works Joints::find_works(const StageContext& c) const noexcept {
  Works works;
  for (const Row& row : rows_)
    if (row.anchored) works.add(work_on_member(c, row));
  return works;
}

void Joints::keep_within_tank(StageContext& c) noexcept {
  if (anchors_.empty()) return;
  Works works = find_works(c);
  if (const double share = share_kept(works, c.border_left_J); share < 1.0) {
    for (Row& row : rows_)
      if (const double work = row.anchored ? work_on_member(c, row) : 0.0; work > 0.0)
        take_back_work(c, row, share * work);
    works = find_works(c);
  }
  c.border_joints_J = works.sum;
}

void Joints::warm_start(StageContext& c) noexcept {
  for (Row& row : rows_) apply(row, side(c, row, row.slot_a), side(c, row, row.slot_b), row.now);
}

// A ghost that may not supply energy does not correct errors. Its row is rigid then: a soft row without error
// correction, whose impulse decays, would release its load within some sub-steps, and with the tank empty that would
// not recover (tests/border/pendulum_cut.toml with three members: 15 N of 100 N).
bool may_push(const StageContext& c, const auto& row) noexcept { return row.ghost == kNoGhost || c.ghosts_may_supply; }

template <bool kBias>
void Joints::solve_axis(const StageContext& c, Row& row, const Side& a, const Side& b) noexcept {
  const Joint& joint = joints_[row.joint];
  const bool turns = joint.kind == JointKind::kHinge;
  const double mass = row.axis_mass;
  Softness<double> soft = kBias && may_push(c, row) ? c.rule.softness : Softness<double>::rigid();
  if (soft.bias_rate > 0.0 && row.ghost != kNoGhost) {
    soft.mass_scale = row.axis_soft_mass * invert_or_zero(mass);
    soft.impulse_scale = row.axis_soft_mass * row.axis_give;
  }
  const double push = soft.mass_scale * soft.bias_rate;
  const auto speed = [&]() noexcept {
    if (turns) return dot(row.axis, b.body.w - a.body.w);
    return dot(row.axis, velocity_at(b.body, row.r_b) - velocity_at(a.body, row.r_a));
  };
  const auto add = [&](double& sum, double next) noexcept {
    JointEffort change;
    change.drive = next - sum;
    sum = next;
    apply(row, a, b, change);
  };
  if (joint.driven) {
    const double most = c.h * joint.motor_effort;
    add(row.now.drive, std::clamp(row.now.drive - mass * (speed() - joint.motor_speed), -most, most));
  }
  if (!joint.limited) return;
  if (joint.low == joint.high) {
    const double error = row.coordinate - joint.low;
    const double last = row.now.lower;
    add(row.now.lower, last - mass * (soft.mass_scale * speed() + (kBias ? push * error : 0.0)) -
                           (kBias ? soft.impulse_scale * last : 0.0));
    return;
  }
  // As a contact: with a gap, it may only close the gap.
  const auto hold = [&](double gap, double closing, double last) noexcept {
    if (gap > 0.0) return std::max(0.0, last - mass * (gap * c.rule.inverse_h + closing));
    return std::max(0.0, last - mass * (soft.mass_scale * closing + (kBias ? push * gap : 0.0)) -
                             (kBias ? soft.impulse_scale * last : 0.0));
  };
  add(row.now.lower, hold(row.coordinate - joint.low, speed(), row.now.lower));
  add(row.now.upper, -hold(joint.high - row.coordinate, -speed(), -row.now.upper));
}

template <bool kBias>
void Joints::solve(StageContext& c) noexcept {
  for (Row& row : rows_) {
    const Softness<double> soft = kBias && may_push(c, row) ? c.rule.softness : Softness<double>::rigid();
    const double rate = soft.bias_rate, push = soft.mass_scale * rate, leak = soft.impulse_scale;
    const bool gives = rate > 0.0 && row.ghost != kNoGhost;
    const Side a = side(c, row, row.slot_a), b = side(c, row, row.slot_b);
    const JointKind kind = joints_[row.joint].kind;
    const Locks locks = locks_of(kind);
    solve_axis<kBias>(c, row, a, b);
    if (locks.angular[0]) {
      const Vec3d u = masked(into(row.axes, b.body.w - a.body.w), locks.angular);
      JointEffort change;
      change.angular =
          gives ? -(row.angular_soft_mass * (u + rate * row.angular_error + row.angular_give * row.now.angular))
                : -(row.angular_mass * (soft.mass_scale * u + push * row.angular_error)) - leak * row.now.angular;
      row.now.angular += change.angular;
      apply(row, a, b, change);
    }
    if (locks.linear[0]) {
      const Vec3d u = masked(into(row.axes, velocity_at(b.body, row.r_b) - velocity_at(a.body, row.r_a)), locks.linear);
      JointEffort change;
      change.linear =
          gives ? -(row.linear_soft_mass * (u + rate * row.linear_error + row.linear_give * row.now.linear))
                : -(row.linear_mass * (soft.mass_scale * u + push * row.linear_error)) - leak * row.now.linear;
      row.now.linear += change.linear;
      apply(row, a, b, change);
    }
  }
}

void Joints::follow(StageContext& c) noexcept {
  for (Row& row : rows_) {
    if (!joints_[row.joint].limited) continue;
    Row moved = row;
    moved.outside.delta_position += c.h * row.outside.v;
    measure(moved, side(c, moved, row.slot_a).body, side(c, moved, row.slot_b).body);
    row.coordinate = moved.coordinate;
  }
}

void Joints::scale(StageContext& c) noexcept {
  for (Row& row : rows_) row.now = c.factor * row.now;
}

void Joints::keep(StageContext&) noexcept {
  for (Row& row : rows_) row.kept = row.now;
}

void Joints::finish(StageContext& c) noexcept {
  const double rate = 1.0 / c.settings.dt;
  for (Row& row : rows_) {
    const bool still =
        (row.slot_a == kOutside || c.frozen[row.slot_a] != 0) && (row.slot_b == kOutside || c.frozen[row.slot_b] != 0);
    if (still) continue;  // solved elsewhere, or not at all
    add_to_sums(c, row);
    const Joint& joint = joints_[row.joint];
    JointState& state = states_[row.joint];
    const JointEffort next = c.factor == 1.0 ? row.now : row.kept + c.factor * (row.now + -1.0 * row.kept);
    state.effort = (1.0 / c.h) * next;
    state.force = rate * row.sum_force;
    state.torque = rate * row.sum_torque;
    state.coordinate = row.coordinate;
    if (norm(state.force) <= joint.break_force_N && norm(state.torque) <= joint.break_torque_Nm) continue;
    state.broken = 1;
    state.effort = {};
    ++c.report.broken_joints;
  }
  for (Anchor& anchor : anchors_) {
    BodyMotion& m = anchor.motion;
    const std::uint32_t ghost = find_ghost(c.ghosts, outside_of(anchor.joint, c.bodies));
    const bool known = ghost != kNoGhost;
    const Vec3d moved = known ? c.ghosts[ghost].moved : c.settings.dt * m.velocity.linear;
    const Vec3d turned = known ? c.ghosts[ghost].turned : c.settings.dt * m.velocity.angular;
    if (known) m.velocity = c.ghosts[ghost].velocity;
    m.pose.position += moved;
    m.pose.rotation = normalized(quat_from_rotation_vector(turned) * m.pose.rotation);
  }
}

template void Joints::solve<true>(StageContext&) noexcept;
template void Joints::solve<false>(StageContext&) noexcept;

}  // namespace tactus::physics
