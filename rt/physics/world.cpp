#include "rt/physics/world.h"

#include <algorithm>

namespace tactus::physics {
namespace {

// A body takes some fifty nanoseconds to measure, handing some over about a microsecond.
constexpr std::uint32_t kFewestBodies = 64;

template <class T>
std::uint32_t lower_slot(const BoundedVector<Body<T>>& bodies, BodyId id) noexcept {
  const auto* at =
      std::lower_bound(bodies.begin(), bodies.end(), id, [](const Body<T>& b, BodyId i) { return b.id < i; });
  return static_cast<std::uint32_t>(at - bodies.begin());
}

template <class T>
bool holds(const BoundedVector<Body<T>>& bodies, std::uint32_t slot, BodyId id) noexcept {
  return slot < bodies.size() && bodies[slot].id == id;
}

}  // namespace

template <class T>
World<T>::World(const Capacities& capacities, Hulls<T> hulls)
    : capacities_(capacities),
      hulls_(hulls),
      bodies_(capacities.bodies),
      fixed_bodies_(capacities.fixed_bodies),
      frozen_(capacities.bodies),
      wrenches_(capacities.bodies),
      bounds_(capacities.bodies),
      fixed_bounds_(capacities.fixed_bodies),
      frames_(capacities.bodies),
      fixed_frames_(capacities.fixed_bodies),
      reach_(capacities.bodies),
      last_poses_(capacities.bodies),
      pair_order_(capacities.bodies, capacities.pairs + 1),
      dynamic_pairs_(capacities.pairs + 1),
      contacts_(capacities),
      solver_(capacities),
      border_contacts_(capacities.border_contacts) {}

template <class T>
bool World<T>::refuse(CapacityBit bit) noexcept {
  refused_bits_ |= bit;
  ++refused_;
  return false;
}

template <class T>
bool World<T>::insert(const Body<T>& body) noexcept {
  const bool fixed = body.kind == BodyKind::kFixed;
  TACTUS_CHECK(body.id <= kMaxBodyId, body.id, kMaxBodyId);
  TACTUS_CHECK(body.shape.kind != ShapeKind::kHull || body.shape.hull < hulls_.size(), body.shape.hull, hulls_.size());
  TACTUS_CHECK(is_finite(body.motion.pose) && is_finite(body.motion.velocity), body.id, 0);
  TACTUS_CHECK(fixed || (body.mass > T(0) && std::isfinite(body.mass)), body.id, body.mass);
  TACTUS_CHECK(
      fixed || (is_finite(body.inertia) && body.inertia.x > T(0) && body.inertia.y > T(0) && body.inertia.z > T(0)),
      body.id, body.inertia.x);
  const std::uint32_t slot = lower_slot(bodies_, body.id), fixed_slot = lower_slot(fixed_bodies_, body.id);
  if (holds(bodies_, slot, body.id) || holds(fixed_bodies_, fixed_slot, body.id)) return false;
  if (fixed) {
    if (!fixed_bodies_.try_insert(fixed_slot, body)) return refuse(kFixedBodiesFull);
    static_cast<void>(fixed_bounds_.try_insert(fixed_slot, bounds_of(body.shape, body.motion.pose, T(0))));
    static_cast<void>(fixed_frames_.try_insert(fixed_slot, BodyFrame<T>::of(body.motion.pose)));
    contacts_.slot_inserted(fixed_slot, true);
    return true;
  }
  if (!bodies_.try_insert(slot, body)) return refuse(kBodiesFull);
  static_cast<void>(frozen_.try_insert(slot, 0));
  static_cast<void>(wrenches_.try_insert(slot, {}));
  static_cast<void>(last_poses_.try_insert(slot, unknown_pose<T>()));
  contacts_.slot_inserted(slot, false);
  if (spring_.enabled && spring_.slot >= slot) ++spring_.slot;
  return true;
}

template <class T>
bool World<T>::remove(BodyId id) noexcept {
  const std::uint32_t slot = lower_slot(bodies_, id), fixed_slot = lower_slot(fixed_bodies_, id);
  if (holds(bodies_, slot, id)) {
    bodies_.erase(slot), frozen_.erase(slot), wrenches_.erase(slot), last_poses_.erase(slot);
    contacts_.slot_removed(slot, false);
    if (spring_.enabled && spring_.slot == slot) spring_.enabled = false;
    if (spring_.enabled && spring_.slot > slot) --spring_.slot;
    return true;
  }
  if (!holds(fixed_bodies_, fixed_slot, id)) return false;
  fixed_bodies_.erase(fixed_slot), fixed_bounds_.erase(fixed_slot), fixed_frames_.erase(fixed_slot);
  contacts_.slot_removed(fixed_slot, true);
  return true;
}

template <class T>
std::int32_t World<T>::slot_of(BodyId id) const noexcept {
  const std::uint32_t slot = lower_slot(bodies_, id);
  return holds(bodies_, slot, id) ? static_cast<std::int32_t>(slot) : -1;
}

template <class T>
std::span<Body<T>> World<T>::bodies() noexcept {
  return bodies_.span();
}
template <class T>
std::span<const Body<T>> World<T>::bodies() const noexcept {
  return bodies_.span();
}
template <class T>
std::span<const Body<T>> World<T>::fixed_bodies() const noexcept {
  return fixed_bodies_.span();
}
template <class T>
std::span<const Aabb<T>> World<T>::bounds() const noexcept {
  return bounds_.span();
}
template <class T>
std::span<const Aabb<T>> World<T>::fixed_bounds() const noexcept {
  return fixed_bounds_.span();
}
template <class T>
BoundedVector<SlotPair>& World<T>::dynamic_pairs() noexcept {
  return dynamic_pairs_;
}
template <class T>
std::span<const Contact<T>> World<T>::contacts() const noexcept {
  return contacts_.contacts();
}
template <class T>
PoseSpring<T>& World<T>::device_spring() noexcept {
  return spring_;
}
template <class T>
BoundedVector<BorderContact<T>>& World<T>::border_contacts() noexcept {
  return border_contacts_;
}
template <class T>
const BoundedVector<BorderContact<T>>& World<T>::border_contacts() const noexcept {
  return border_contacts_;
}

template <class T>
bool World<T>::add_border_contact(const BorderContact<T>& contact) noexcept {
  return border_contacts_.try_push(contact) || refuse(kBorderContactsFull);
}

template <class T>
bool World<T>::add_warm_start(const WarmStart<T>& warm_start) noexcept {
  return contacts_.add_warm_start(warm_start);
}

template <class T>
WarmStart<T> World<T>::warm_start_of(const Contact<T>& contact, T sub_step_s) noexcept {
  WarmStart<T> out;
  out.key = contact.key;
  out.axis_cache = contact.axis_cache;
  out.count = contact.count;
  const auto [t1, t2] = tangents_of(contact.normal);
  for (std::uint32_t i = 0; i < contact.count; ++i) {
    const ContactPoint<T>& point = contact.points[i];
    out.features[i] = point.feature;
    out.normal_force[i] = point.normal_impulse / sub_step_s;
    out.friction_force[i] = (point.tangent_impulse[0] * t1 + point.tangent_impulse[1] * t2) * (T(1) / sub_step_s);
  }
  return out;
}

template <class T>
void World<T>::apply_wrench(std::uint32_t slot, const Wrench<T>& wrench) noexcept {
  TACTUS_CHECK(slot < bodies_.size(), slot, bodies_.size());
  wrenches_[slot].force += wrench.force, wrenches_[slot].torque += wrench.torque;
  wrench_applied_ = true;
}

template <class T>
void World<T>::apply_impulse(std::uint32_t slot, const Wrench<T>& impulse) noexcept {
  TACTUS_CHECK(slot < bodies_.size(), slot, bodies_.size());
  if (frozen_[slot] != 0) return;
  Body<T>& body = bodies_[slot];
  const Quat<T>& q = body.motion.pose.rotation;
  const Vec3<T> torque = rotate_inverse(q, impulse.torque);
  body.motion.velocity.linear += (T(1) / body.mass) * impulse.force;
  body.motion.velocity.angular +=
      rotate(q, Vec3<T>{torque.x / body.inertia.x, torque.y / body.inertia.y, torque.z / body.inertia.z});
}

template <class T>
void World<T>::set_frozen(std::uint32_t slot, bool frozen) noexcept {
  TACTUS_CHECK(slot < bodies_.size(), slot, bodies_.size());
  frozen_[slot] = frozen ? 1 : 0;
}

template <class T>
void World<T>::begin_step(const StepSettings<T>& settings) noexcept {
  dynamic_pairs_.clear();
  contacts_.clear_pairs();
  const auto count = bodies_.size();
  bounds_.resize(count), reach_.resize(count), frames_.resize(count);
  // Semi-implicit: s sub-steps fall (1 + 1 / s) times the parabola.
  const T fall =
      T(0.5) * (T(1) + T(1) / static_cast<T>(settings.sub_steps)) * norm(settings.gravity) * settings.dt * settings.dt;
  const auto measure = [&](std::uint32_t i) noexcept {
    const Body<T>& body = bodies_[i];
    const Twist<T>& velocity = body.motion.velocity;
    T speed = norm(velocity.linear) + norm(velocity.angular) * bounding_radius(body.shape);
    if (spring_.enabled && spring_.slot == i) speed = std::max(speed, norm(spring_.target_velocity.linear));
    reach_[i] = frozen_[i] != 0 ? Reach<T>{} : Reach<T>{speed * settings.dt, std::abs(body.gravity_scale) * fall};
    measure_motion(last_poses_[i], body.motion.pose, kLargestGap<T>, reach_[i]);
    frames_[i] = BodyFrame<T>::of(body.motion.pose);
    // The bounds of two bodies grow by at least the margin of their pair.
    const T margin = std::min(std::max(settings.min_margin, reach_[i].moved + reach_[i].fallen), settings.max_margin);
    bounds_[i] = bounds_of(body.shape, body.motion.pose, margin);
  };
  executor_.for_each_range(count, kFewestBodies, [&](std::uint32_t i, std::uint32_t end) noexcept {
    for (; i < end; ++i) measure(i);
  });
}

template <class T>
void World<T>::add_pairs() noexcept {
  // A finder may find too much: it must not show.
  const auto counts = [this](const SlotPair& pair) noexcept {
    TACTUS_CHECK(pair.a < bodies_.size() && pair.b < bodies_.size() && pair.a != pair.b, pair.a, pair.b);
    return bounds_[pair.a].overlaps(bounds_[pair.b]) && (frozen_[pair.a] & frozen_[pair.b]) == 0;
  };
  std::uint32_t kept = 0;
  for (std::uint32_t i = 0; i < dynamic_pairs_.size(); ++i) {
    const SlotPair pair = dynamic_pairs_[i];
    if (counts(pair)) dynamic_pairs_[kept++] = pair;
  }
  dynamic_pairs_.resize(kept);
  pair_order_.sort(dynamic_pairs_, bodies_.size());
  for (const auto& [a, b] : dynamic_pairs_) contacts_.add_pair(PairKey::of(bodies_[a].id, bodies_[b].id, false), a, b);
}

template <class T>
void World<T>::add_fixed_pairs() noexcept {
  for (std::uint32_t f = 0; f < fixed_bodies_.size(); ++f) {
    const Body<T>& fixed = fixed_bodies_[f];
    const bool plane = fixed.shape.kind == ShapeKind::kPlane;
    const Aabb<T> bounds = fixed_bounds_[f];
    const Vec3<T> normal = fixed_frames_[f].axes.z, origin = fixed_frames_[f].position;
    // May the box reach below the plane (the half space z <= 0 of its frame)?
    const auto reaches_plane = [&](const Aabb<T>& box) noexcept {
      const Vec3<T> lowest{normal.x > T(0) ? box.lower.x : box.upper.x, normal.y > T(0) ? box.lower.y : box.upper.y,
                           normal.z > T(0) ? box.lower.z : box.upper.z};
      return dot(normal, lowest - origin) <= T(0);
    };
    for (std::uint32_t i = 0; i < bodies_.size(); ++i) {
      if (!(plane ? reaches_plane(bounds_[i]) : bounds_[i].overlaps(bounds)) || frozen_[i] != 0) continue;
      contacts_.add_pair(PairKey::of(bodies_[i].id, fixed.id, true), i, f);
    }
  }
}

template <class T>
StepReport<T> World<T>::finish_step(const StepSettings<T>& settings, const CutPredicate& cut) noexcept {
  TACTUS_CHECK(settings.sub_steps > 0 && settings.dt > T(0), settings.sub_steps, settings.dt);
  TACTUS_CHECK(bounds_.size() == bodies_.size(), bounds_.size(), bodies_.size());
  StepReport<T> report;
  report.capacity_bits = refused_bits_, report.dropped = refused_;
  refused_bits_ = 0, refused_ = 0;
  const T h = settings.dt / static_cast<T>(settings.sub_steps);
  const T impulse_scale = last_sub_step_ > T(0) && last_sub_step_ != h ? h / last_sub_step_ : T(1);
  last_sub_step_ = h;

  add_pairs();
  add_fixed_pairs();
  contacts_.build({bodies_.span(), fixed_bodies_.span(), frames_.span(), fixed_frames_.span(), reach_.span(), hulls_},
                  settings, h, impulse_scale, report, executor_);
  for (std::uint32_t i = 0; i < bodies_.size(); ++i) last_poses_[i] = bodies_[i].motion.pose;
  const std::span<const Wrench<T>> wrenches =
      wrench_applied_ ? std::span<const Wrench<T>>(wrenches_.span()) : std::span<const Wrench<T>>();
  solver_.step({bodies_.span(), frozen_.span(), wrenches, contacts_.contacts(), spring_, border_contacts_.span(),
                border_mode, impulse_scale, executor_},
               settings, cut, report);
  if (wrench_applied_)
    for (Wrench<T>& wrench : wrenches_) wrench = {};
  wrench_applied_ = false;
  return report;
}

template class World<double>;
template class World<float>;

}  // namespace tactus::physics
