// The joints in use, and their state from step to step and between worlds; the rows are in joint_rows.cpp.
#include "rt/physics/effects/joints.h"

#include <algorithm>
#include <numbers>

#include "rt/physics/body_search.h"

namespace tactus::physics {
namespace {

bool is_finite_effort(const JointEffort& e) noexcept {
  return is_finite(e.linear) && is_finite(e.angular) && std::isfinite(e.drive) && std::isfinite(e.lower) &&
         std::isfinite(e.upper);
}

// Flags of an exported joint.
constexpr std::uint32_t kBroken = 1, kAnchored = 2;

bool comes_before(const SlotPair& p, const SlotPair& q) noexcept { return p.a != q.a ? p.a < q.a : p.b < q.b; }

// Removes the pairs in `apart` from `pairs`; both are sorted alike.
void take_out(BoundedVector<SlotPair>& pairs, const BoundedVector<SlotPair>& apart) noexcept {
  std::uint32_t kept = 0, next = 0;
  for (std::uint32_t i = 0; i < pairs.size(); ++i) {
    const SlotPair pair = pairs[i];
    while (next < apart.size() && comes_before(apart[next], pair)) ++next;
    if (next == apart.size() || comes_before(pair, apart[next])) pairs[kept++] = pair;
  }
  pairs.resize(kept);
}

}  // namespace

Joints::Joints(const Setup& setup, const Capacities&) : joints_(setup.joints) {
  const auto count = static_cast<std::uint32_t>(joints_.size());
  BodyId highest = 0;
  for (const Joint& joint : joints_) {
    TACTUS_CHECK(joint.b <= kMaxBodyId && (joint.a == kNoBody || joint.a <= kMaxBodyId), joint.a, joint.b);
    highest = std::max(highest, joint.a == kNoBody ? joint.b : std::max(joint.a, joint.b));
  }
  states_ = BoundedVector<JointState>(count);
  states_.resize(count);
  first_of_ = BoundedVector<std::uint32_t>(highest + 2);
  first_of_.resize(highest + 2);
  joints_of_ = BoundedVector<std::uint32_t>(2 * count);
  anchors_ = BoundedVector<Anchor>(count);
  rows_ = BoundedVector<Row>(count);
  apart_ = BoundedVector<SlotPair>(count);
  apart_fixed_ = BoundedVector<SlotPair>(count);
  for (BodyId id = 0; id <= highest; ++id) first_of_[id] = 0;
  for (const Joint& joint : joints_) {
    ++first_of_[joint.b];
    if (joint.a != kNoBody) ++first_of_[joint.a];
  }
  std::uint32_t sum = 0;
  for (BodyId id = 0; id <= highest + 1; ++id) {
    const std::uint32_t own = id <= highest ? first_of_[id] : 0;
    sum += own;
    first_of_[id] = sum;  // the end; filling backwards turns it into the start
  }
  joints_of_.resize(sum);
  for (std::uint32_t k = count; k-- > 0;) {
    joints_of_[--first_of_[joints_[k].b]] = k;
    if (joints_[k].a != kNoBody) joints_of_[--first_of_[joints_[k].a]] = k;
  }
}

void Joints::register_stages(StageTable& table) noexcept {
  table.add<&Joints::find_active>(Phase::kPairs, *this);
  table.add<&Joints::separate>(Phase::kPairs, *this);
  table.add<&Joints::separate_fixed>(Phase::kFixedPairs, *this);
  table.add<&Joints::prepare>(Phase::kPrepare, *this);
  table.add<&Joints::begin_sub_step>(Phase::kBeginSubStep, *this);
  table.add<&Joints::warm_start>(Phase::kWarmStart, *this);
  table.add<&Joints::solve<true>>(Phase::kBiased, *this);
  table.add<&Joints::follow>(Phase::kMoved, *this);
  table.add<&Joints::solve<false>>(Phase::kRelax, *this);
  table.add<&Joints::scale>(Phase::kScale, *this);
  table.add<&Joints::keep>(Phase::kKeep, *this);
  table.add<&Joints::keep_within_tank>(Phase::kEndSubStep, *this);
  table.add<&Joints::finish>(Phase::kFinish, *this);
}

bool Joints::is_sound(const Anchor& anchor) noexcept {
  const Vec3d& i = anchor.inverse_inertia;
  return is_finite(anchor.motion.pose) && is_finite(anchor.motion.velocity) && std::isfinite(anchor.inverse_mass) &&
         anchor.inverse_mass >= 0.0 && is_finite(i) && i.x >= 0.0 && i.y >= 0.0 && i.z >= 0.0;
}

std::uint32_t Joints::slot_of(std::span<const Body> bodies, BodyId id) noexcept {
  return id == kNoBody ? kNoSlot : find_slot(bodies, id);
}

std::span<const std::uint32_t> Joints::joints_of(BodyId id) const noexcept {
  if (id + 1 >= first_of_.size()) return {};
  return joints_of_.span().subspan(first_of_[id], first_of_[id + 1] - first_of_[id]);
}

const Joints::Anchor* Joints::anchor_of(std::uint32_t joint) const noexcept {
  const auto* at = std::lower_bound(anchors_.begin(), anchors_.end(), joint,
                                    [](const Anchor& x, std::uint32_t k) { return x.joint < k; });
  return at != anchors_.end() && at->joint == joint ? at : nullptr;
}

template <class F>
void Joints::for_each_active(std::span<const Body> bodies, std::span<const Body> fixed_bodies, F&& f) const noexcept {
  for (std::uint32_t slot = 0; slot < bodies.size(); ++slot)
    for (const std::uint32_t k : joints_of(bodies[slot].id)) {
      const Joint& joint = joints_[k];
      if (states_[k].broken != 0) continue;
      if (joint.b != bodies[slot].id) {
        if (slot_of(bodies, joint.b) == kNoSlot && anchor_of(k) != nullptr) f(k, slot, kOutside);
        continue;
      }
      const std::uint32_t slot_a = slot_of(bodies, joint.a);
      const bool known = slot_a != kNoSlot || joint.a == kNoBody || slot_of(fixed_bodies, joint.a) != kNoSlot;
      if (known || anchor_of(k) != nullptr) f(k, slot_a, slot);
    }
}

void Joints::find_active(StageContext& c) noexcept {
  rows_.clear();
  apart_.clear();
  apart_fixed_.clear();
  for_each_active(c.bodies, c.fixed_bodies, [&](std::uint32_t k, std::uint32_t slot_a, std::uint32_t slot_b) noexcept {
    add_row(c, k, slot_a, slot_b);
    if (joints_[k].bodies_collide || slot_b == kOutside) return;
    if (slot_a != kOutside) {
      (void)apart_.try_push({std::min(slot_a, slot_b), std::max(slot_a, slot_b)});
    } else if (const std::uint32_t fixed = slot_of(c.fixed_bodies, joints_[k].a); fixed != kNoSlot) {
      (void)apart_fixed_.try_push({fixed, slot_b});
    }
  });
  c.report.joints = rows_.size();
  std::sort(apart_.begin(), apart_.end(), comes_before);
  std::sort(apart_fixed_.begin(), apart_fixed_.end(), comes_before);
}

// The joint's frames at the bodies' poses; of a body of another world, at its anchor.
Joints::Row Joints::row_of(std::uint32_t k, std::uint32_t slot_a, std::uint32_t slot_b, std::span<const Body> bodies,
                           std::span<const Body> fixed_bodies) const noexcept {
  const Joint& joint = joints_[k];
  Row row;
  row.joint = k;
  row.slot_a = slot_a;
  row.slot_b = slot_b;
  if (slot_a == kOutside || slot_b == kOutside) {
    const BodyId id = slot_a == kOutside ? joint.a : joint.b;
    const std::uint32_t fixed = slot_of(fixed_bodies, id);
    row.anchored = fixed == kNoSlot && id != kNoBody;
    if (fixed != kNoSlot) row.outside_motion = {fixed_bodies[fixed].motion.pose, {}};
    if (row.anchored) row.outside_motion = anchor_of(k)->motion;
  }
  const Posed& a = slot_a == kOutside ? row.outside_motion.pose : bodies[slot_a].motion.pose;
  const Posed& b = slot_b == kOutside ? row.outside_motion.pose : bodies[slot_b].motion.pose;
  row.arm_a = rotate(a.rotation, joint.a_from_joint.position);
  row.arm_b = rotate(b.rotation, joint.b_from_joint.position);
  row.apart = (b.position - a.position) + (row.arm_b - row.arm_a);
  row.frame_a = a.rotation * joint.a_from_joint.rotation;
  row.frame_b = b.rotation * joint.b_from_joint.rotation;
  return row;
}

void Joints::add_row(StageContext& c, std::uint32_t k, std::uint32_t slot_a, std::uint32_t slot_b) noexcept {
  Row row = row_of(k, slot_a, slot_b, c.bodies, c.fixed_bodies);
  if (row.anchored) {
    const Anchor& anchor = *anchor_of(k);
    row.own_inverse_mass = anchor.inverse_mass;
    row.own_inverse_inertia = rotate_diagonal(anchor.motion.pose.rotation, anchor.inverse_inertia);
  }
  (void)rows_.try_push(row);  // never fails: capacity for all joints
}

double Joints::springs_J(std::span<const Body> bodies, std::span<const Body> fixed_bodies,
                         std::span<const std::uint8_t> frozen, double contact_hertz) const noexcept {
  double sum = 0.0;
  for_each_active(bodies, fixed_bodies, [&](std::uint32_t k, std::uint32_t slot_a, std::uint32_t slot_b) noexcept {
    Row row = row_of(k, slot_a, slot_b, bodies, fixed_bodies);
    if (row.anchored) return;
    SolverBody<double> a, b;
    SymMat3d inertia_a, inertia_b;
    const auto take = [&](std::uint32_t slot, SolverBody<double>& body, SymMat3d& inverse_inertia) noexcept {
      if (slot == kOutside || frozen[slot] != 0) return;
      body.inverse_mass = 1.0 / bodies[slot].mass;
      const Vec3d& inertia = bodies[slot].inertia;
      inverse_inertia =
          rotate_diagonal(bodies[slot].motion.pose.rotation, Vec3d{1.0 / inertia.x, 1.0 / inertia.y, 1.0 / inertia.z});
    };
    take(slot_a, a, inertia_a);
    take(slot_b, b, inertia_b);
    measure(row, a, b);
    fill_masses(row, {a, inertia_a}, {b, inertia_b});
    sum += dot(row.linear_error, row.linear_mass * row.linear_error);
    sum += dot(row.angular_error, row.angular_mass * row.angular_error);
    const Joint& joint = joints_[k];
    const double beyond = std::max({0.0, joint.low - row.coordinate, row.coordinate - joint.high});
    if (joint.limited) sum += row.axis_mass * beyond * beyond;
  });
  const double omega = 2.0 * std::numbers::pi * contact_hertz;
  return 0.5 * omega * omega * sum;
}

// The body of another world to which the joint is connected.
BodyId Joints::outside_of(std::uint32_t joint, std::span<const Body> bodies) const noexcept {
  return slot_of(bodies, joints_[joint].b) == kNoSlot ? joints_[joint].b : joints_[joint].a;
}

void Joints::separate(StageContext& c) noexcept {
  if (!apart_.empty()) take_out(*c.pairs, apart_);
}

void Joints::separate_fixed(StageContext& c) noexcept {
  if (!apart_fixed_.empty()) take_out(*c.pairs, apart_fixed_);
}

void Joints::save(ByteWriter& out) const noexcept {
  for (const JointState& s : states_)  // field by field: the struct has padding
  {
    out.put(s.effort);
    out.put(s.force);
    out.put(s.torque);
    out.put(s.coordinate);
    out.put(s.broken);
  }
  out.put(anchors_.size());
  for (const Anchor& anchor : anchors_) {
    out.put(anchor.joint);
    out.put(anchor.motion);
    out.put(anchor.inverse_mass);
    out.put(anchor.inverse_inertia);
  }
}

std::size_t Joints::save_size_bound() const noexcept {
  return states_.size() * (sizeof(JointState) + sizeof(Anchor)) + sizeof(std::uint32_t);
}

bool Joints::restore(ByteReader& in) noexcept {
  anchors_.clear();
  for (JointState& s : states_) {
    in.get(s.effort);
    in.get(s.force);
    in.get(s.torque);
    in.get(s.coordinate);
    in.get(s.broken);
  }
  std::uint32_t count = 0;
  in.get(count);
  bool good = in.ok() && count <= anchors_.capacity();
  for (std::uint32_t i = 0; good && i < count; ++i) {
    Anchor anchor;
    in.get(anchor.joint);
    in.get(anchor.motion);
    in.get(anchor.inverse_mass);
    in.get(anchor.inverse_inertia);
    good = in.ok() && anchor.joint < joints_.size() && (i == 0 || anchors_[i - 1].joint < anchor.joint) &&
           is_sound(anchor) && anchors_.try_push(anchor);
  }
  for (JointState& state : states_)
    if (!is_finite_effort(state.effort) || !is_finite(state.force) || !is_finite(state.torque) || state.broken > 1) {
      state = {};
      good = false;
    }
  return good;
}

// Format: count, then for each joint with a body inside: its index, flags (1: broken, 2: one of its bodies is outside),
// its effort, and, if one body is outside, that body's motion and inverse masses.
void Joints::export_state(ByteWriter& out, std::span<const Body> bodies,
                          std::span<const std::uint8_t> inside) const noexcept {
  const auto is_inside = [&](std::uint32_t slot) noexcept {
    return slot != kNoSlot && (inside.empty() || inside[slot] != 0);
  };
  const auto each = [&](auto&& f) noexcept {  // f(joint, slot of its body that is not inside, or kNoSlot)
    for (std::uint32_t slot = 0; slot < bodies.size(); ++slot) {
      if (!is_inside(slot)) continue;
      for (const std::uint32_t k : joints_of(bodies[slot].id)) {
        const bool is_b = joints_[k].b == bodies[slot].id;
        const std::uint32_t other = slot_of(bodies, is_b ? joints_[k].a : joints_[k].b);
        if (!is_inside(other))
          f(k, other);
        else if (is_b)
          f(k, kNoSlot);
      }
    }
  };
  std::uint32_t count = 0;
  each([&](std::uint32_t, std::uint32_t) noexcept { ++count; });
  out.put(count);
  each([&](std::uint32_t k, std::uint32_t beyond) noexcept {
    out.put(k);
    out.put(states_[k].broken | (beyond != kNoSlot ? kAnchored : 0u));
    out.put(states_[k].effort);
    if (beyond == kNoSlot) return;
    const Body& body = bodies[beyond];
    out.put(body.motion);
    out.put(1.0 / body.mass);
    out.put(Vec3d{1.0 / body.inertia.x, 1.0 / body.inertia.y, 1.0 / body.inertia.z});
  });
}

void Joints::reset() noexcept {
  std::fill(states_.begin(), states_.end(), JointState{});
  anchors_.clear();
}

bool Joints::import_state(ByteReader& in, std::span<const Body> bodies, bool known_too) noexcept {
  std::uint32_t count = 0;
  in.get(count);
  if (!known_too) anchors_.clear();
  for (std::uint32_t i = 0; i < count && in.ok(); ++i) {
    Anchor anchor;
    std::uint32_t flags = 0;
    JointEffort effort;
    in.get(anchor.joint);
    in.get(flags);
    in.get(effort);
    if ((flags & kAnchored) != 0) {
      in.get(anchor.motion);
      in.get(anchor.inverse_mass);
      in.get(anchor.inverse_inertia);
    }
    if (!in.ok() || anchor.joint >= joints_.size() || !is_finite_effort(effort) || !is_sound(anchor)) return false;
    const Joint& joint = joints_[anchor.joint];
    JointState& state = states_[anchor.joint];
    const bool known =
        slot_of(bodies, joint.b) != kNoSlot && (joint.a == kNoBody || slot_of(bodies, joint.a) != kNoSlot);
    if (known_too || !known) state.effort = effort;
    if ((flags & kBroken) != 0) {
      state.broken = 1;
      state.effort = {};
    }
    if (!known_too && (flags & kAnchored) != 0) (void)anchors_.try_push(anchor);
  }
  std::sort(anchors_.begin(), anchors_.end(), [](const Anchor& p, const Anchor& q) { return p.joint < q.joint; });
  return in.ok();
}

}  // namespace tactus::physics
