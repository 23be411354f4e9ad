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

// May the box reach below the plane, the half space z <= 0 of its frame?
template <class T>
bool reaches_plane(const Aabb<T>& box, const BodyFrame<T>& plane) noexcept {
  const Vec3<T>& normal = plane.axes.z;
  const Vec3<T> lowest{normal.x > T(0) ? box.lower.x : box.upper.x, normal.y > T(0) ? box.lower.y : box.upper.y,
                       normal.z > T(0) ? box.lower.z : box.upper.z};
  return dot(normal, lowest - plane.position) <= T(0);
}

}  // namespace

template <class T>
World<T>::World(const Capacities& capacities, Hulls<T> hulls, Meshes<T> meshes, const EffectSetups<T>& effects,
                SweepPrecision precision)
    : capacities_(capacities),
      hulls_(hulls),
      meshes_(meshes),
      bodies_(capacities.bodies),
      fixed_bodies_(capacities.fixed_bodies),
      frozen_(capacities.bodies),
      held_(capacities.bodies),
      wrenches_(capacities.bodies),
      bounds_(capacities.bodies),
      fixed_bounds_(capacities.fixed_bodies),
      frames_(capacities.bodies),
      fixed_frames_(capacities.fixed_bodies),
      reach_(capacities.bodies),
      last_poses_(capacities.bodies),
      moved_to_(capacities.bodies),
      fixed_tree_(capacities.fixed_bodies),
      fixed_pairs_(capacities.pairs),
      mesh_triangles_(capacities.mesh_triangles),
      pair_order_(capacities.bodies, capacities.pairs + 1),
      dynamic_pairs_(capacities.pairs + 1),
      contacts_(capacities),
      effects_(effects, capacities),
      border_contacts_(capacities.border_contacts),
      border_ghosts_(capacities.border_contacts) {
  if (precision == SweepPrecision::kSingle && effects_.only_gravity())
    single_solver_.emplace(capacities);
  else
    solver_.emplace(capacities);
}

template <class T>
bool World<T>::refuse(CapacityBit bit) noexcept {
  refused_bits_ |= bit;
  ++refused_;
  return false;
}

template <class T>
bool World<T>::insert(const Body<T>& body) noexcept {
  const bool fixed = body.kind == BodyKind::kFixed;
  TACTUS_CHECK(body.id < kFirstPatchId, body.id, kFirstPatchId);
  TACTUS_CHECK(body.shape.kind != ShapeKind::kHull || body.shape.index < hulls_.size(), body.shape.index,
               hulls_.size());
  TACTUS_CHECK(body.shape.kind != ShapeKind::kMesh || (fixed && body.shape.index < meshes_.size()), body.shape.index,
               meshes_.size());
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
    fixed_is_indexed_ = false;
    return true;
  }
  if (!bodies_.try_insert(slot, body)) return refuse(kBodiesFull);
  static_cast<void>(frozen_.try_insert(slot, 0));
  static_cast<void>(wrenches_.try_insert(slot, {}));
  static_cast<void>(last_poses_.try_insert(slot, unknown_pose<T>()));
  contacts_.slot_inserted(slot, false);
  for (auto& spring : springs_)
    if (spring.enabled && spring.slot >= slot) ++spring.slot;
  return true;
}

template <class T>
bool World<T>::remove(BodyId id) noexcept {
  const std::uint32_t slot = lower_slot(bodies_, id), fixed_slot = lower_slot(fixed_bodies_, id);
  if (holds(bodies_, slot, id)) {
    bodies_.erase(slot), frozen_.erase(slot), wrenches_.erase(slot), last_poses_.erase(slot);
    contacts_.slot_removed(slot, false);
    for (auto& spring : springs_) {
      if (spring.enabled && spring.slot == slot) spring.enabled = false;
      if (spring.enabled && spring.slot > slot) --spring.slot;
    }
    return true;
  }
  if (!holds(fixed_bodies_, fixed_slot, id)) return false;
  fixed_bodies_.erase(fixed_slot), fixed_bounds_.erase(fixed_slot), fixed_frames_.erase(fixed_slot);
  contacts_.slot_removed(fixed_slot, true);
  fixed_is_indexed_ = false;
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
  index_fixed_bodies();
  const auto count = bodies_.size();
  bounds_.resize(count), reach_.resize(count), frames_.resize(count);
  const T fall = fall_in_step(settings);
  growth_to_fixed_ = growth_to_fixed(fall, settings);
  const auto measure = [&](std::uint32_t i) noexcept {
    const Body<T>& body = bodies_[i];
    const Twist<T>& velocity = body.motion.velocity;
    T speed = norm(velocity.linear) + norm(velocity.angular) * bounding_radius(body.shape);
    for (const auto& spring : springs_)
      if (spring.enabled && spring.slot == i) speed = std::max(speed, norm(spring.target_velocity.linear));
    reach_[i] = {};
    if (frozen_[i] == 0) reach_[i].moved = speed * settings.dt, reach_[i].fallen = std::abs(body.gravity_scale) * fall;
    measure_motion(last_poses_[i], body.motion.pose, kLargestGap<T>, reach_[i]);
    frames_[i] = BodyFrame<T>::of(body.motion.pose);
    bounds_[i] = bounds_of(body.shape, body.motion.pose, growth_of(reach_[i], fall, settings));
  };
  executor_.for_each_range(count, kFewestBodies, [&](std::uint32_t i, std::uint32_t end) noexcept {
    for (; i < end; ++i) measure(i);
  });
}

template <class T>
void World<T>::add_pairs(StageContext<T>& context) noexcept {
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
  context.pairs = &dynamic_pairs_;
  effects_.stages().run(Phase::kPairs, context);
  for (const auto& [a, b] : dynamic_pairs_) contacts_.add_pair(PairKey::of(bodies_[a].id, bodies_[b].id, false), a, b);
}

template <class T>
void World<T>::index_fixed_bodies() noexcept {
  if (fixed_is_indexed_) return;
  fixed_tree_.build(fixed_bounds_.span());
  fixed_is_indexed_ = true;
}

template <class T>
void World<T>::add_fixed_pair(const SlotPair& pair, const StepSettings<T>& settings, StepReport<T>& report) noexcept {
  const auto [f, i] = pair;
  if (fixed_bodies_[f].shape.kind == ShapeKind::kMesh)
    add_mesh_pairs(i, f, margin_to_fixed(reach_[i], settings), report);
  else
    contacts_.add_pair(PairKey::of(bodies_[i].id, fixed_bodies_[f].id, true), i, f);
}

// Those of the tree: the fixed body's slot, the moving one's, in that order. What the list does not hold is added at
// once: the contact table counts what it leaves out.
template <class T>
void World<T>::find_fixed_pairs(const StepSettings<T>& settings, StepReport<T>& report) noexcept {
  fixed_pairs_.clear();
  const auto found = [&](std::uint32_t f, std::uint32_t i) noexcept {
    if (!fixed_pairs_.try_push({f, i})) add_fixed_pair({f, i}, settings, report);
    return true;
  };
  // Bodies that are close together meet few fixed ones: then the tree is asked once for all of them.
  FixedVector<std::uint32_t, 16> near;
  bool few = true;
  if (!bodies_.empty()) {
    Aabb<T> all = bounds_[0];
    for (const Aabb<T>& box : bounds_) all = join(all, box);
    fixed_tree_.find(all.grown(growth_to_fixed_), [&](std::uint32_t f) noexcept { return few = near.try_push(f); });
  }
  for (std::uint32_t i = 0; i < bodies_.size(); ++i) {
    if (frozen_[i] != 0) continue;
    const Aabb<T> box = bounds_[i].grown(growth_to_fixed_);
    if (!few) {
      fixed_tree_.find(box, [&](std::uint32_t f) noexcept { return found(f, i); });
      continue;
    }
    for (const std::uint32_t f : near)
      if (fixed_bounds_[f].overlaps(box)) found(f, i);
  }
  std::sort(fixed_pairs_.begin(), fixed_pairs_.end(),
            [](const SlotPair& p, const SlotPair& q) { return p.a != q.a ? p.a < q.a : p.b < q.b; });
}

// In the order of the fixed bodies, mostly that of the keys: planes, which no tree holds, between the others.
template <class T>
void World<T>::add_fixed_pairs(StageContext<T>& context) noexcept {
  const auto add = [&](const SlotPair& pair) noexcept { add_fixed_pair(pair, context.settings, context.report); };
  mesh_triangles_.clear();
  find_fixed_pairs(context.settings, context.report);
  context.pairs = &fixed_pairs_;
  effects_.stages().run(Phase::kFixedPairs, context);
  std::uint32_t next = 0;
  const auto add_below = [&](std::uint32_t end) noexcept {
    for (; next < fixed_pairs_.size() && fixed_pairs_[next].a < end; ++next) add(fixed_pairs_[next]);
  };
  for (const std::uint32_t f : fixed_tree_.unbounded()) {
    add_below(f);
    for (std::uint32_t i = 0; i < bodies_.size(); ++i)
      if (frozen_[i] == 0 && reaches_plane(bounds_[i].grown(growth_to_fixed_), fixed_frames_[f])) add({f, i});
  }
  add_below(fixed_bodies_.size());
}

// One pair for each patch that the body is near to, with the patch's triangles.
template <class T>
void World<T>::add_mesh_pairs(std::uint32_t slot, std::uint32_t fixed_slot, T margin, StepReport<T>& report) noexcept {
  const Body<T>&body = bodies_[slot], &fixed = fixed_bodies_[fixed_slot];
  const Mesh<T>& mesh = meshes_[fixed.shape.index];
  const Aabb<T> box = bounds_of(body.shape, relative_pose(fixed.motion.pose, body.motion.pose), margin);
  TriangleList near;
  near_triangles.find(mesh, body.id, fixed.shape.index, box, near);
  std::uint32_t left_out = near.left_out;
  PatchTriangles stretch{mesh_triangles_.size(), 0};
  std::uint32_t patch = 0;
  const auto add_pair = [&]() noexcept {
    if (stretch.count > 0)
      contacts_.add_pair(PairKey::of(body.id, mesh.first_patch_id + patch, true), slot, fixed_slot, stretch);
    stretch = {mesh_triangles_.size(), 0};
  };
  for (const std::uint32_t triangle : near.triangles) {
    if (!reaches_plane(mesh, box, triangle)) continue;
    if (mesh.triangles[triangle].patch != patch) add_pair(), patch = mesh.triangles[triangle].patch;
    if (mesh_triangles_.try_push(triangle))
      ++stretch.count;
    else
      ++left_out;
  }
  add_pair();
  if (left_out == 0) return;
  report.capacity_bits |= kMeshTrianglesFull;
  report.dropped += left_out;
}

template <class T>
StepReport<T> World<T>::finish_step(const StepSettings<T>& settings, const CutPredicate& cut,
                                    const FarRegion& far) noexcept {
  TACTUS_CHECK(settings.sub_steps > 0 && settings.dt > T(0), settings.sub_steps, settings.dt);
  TACTUS_CHECK(bounds_.size() == bodies_.size(), bounds_.size(), bodies_.size());
  StepReport<T> report;
  report.capacity_bits = refused_bits_, report.dropped = refused_;
  refused_bits_ = 0, refused_ = 0;
  const T h = settings.dt / static_cast<T>(settings.sub_steps);
  const T impulse_scale = last_sub_step_ > T(0) && last_sub_step_ != h ? h / last_sub_step_ : T(1);
  last_sub_step_ = h;

  StageContext<T> context{bodies_.span(), fixed_bodies_.span(), frozen_.span(), {}, settings, report, executor_};
  add_pairs(context);
  add_fixed_pairs(context);
  contacts_.build({bodies_.span(), fixed_bodies_.span(), frames_.span(), fixed_frames_.span(), reach_.span(), hulls_,
                   meshes_, mesh_triangles_.span()},
                  settings, h, impulse_scale, report, executor_);
  for (std::uint32_t i = 0; i < bodies_.size(); ++i) last_poses_[i] = bodies_[i].motion.pose;
  if (far.bodies.empty()) {
    solve(frozen_.span(), springs_, settings, impulse_scale, cut, report);
  } else {
    held_.resize(bodies_.size());
    for (std::uint32_t i = 0; i < bodies_.size(); ++i) held_[i] = frozen_[i] | far.bodies[i];
    solve(held_.span(), springs_, settings, impulse_scale, cut, report);
    solve_far(far, settings, cut, report);
  }
  if (wrench_applied_)
    for (Wrench<T>& wrench : wrenches_) wrench = {};
  wrench_applied_ = false;
  return report;
}

// Bodies that are held neither move nor feel impulses.
template <class T>
void World<T>::solve(std::span<const std::uint8_t> held, std::span<PoseSpring<T>> springs,
                     const StepSettings<T>& settings, T impulse_scale, const CutPredicate& cut,
                     StepReport<T>& report) noexcept {
  const std::span<const Wrench<T>> wrenches =
      wrench_applied_ ? std::span<const Wrench<T>>(wrenches_.span()) : std::span<const Wrench<T>>();
  const SolverInput<T> input{bodies_.span(),
                             held,
                             wrenches,
                             contacts_.contacts(),
                             springs,
                             border_contacts_.span(),
                             border_ghosts_.span(),
                             border_mode,
                             border_budget_J,
                             impulse_scale,
                             effects_.stages(),
                             fixed_bodies_.span(),
                             executor_};
  if (solver_) return solver_->step(input, settings, cut, report);
  TACTUS_CHECK(border_contacts_.empty(), bodies_.size(), border_contacts_.size());
  single_solver_->step(input, settings, cut, report);
}

// The others have been solved, and are held. Between steps all impulses are those of the near region's sub-step.
template <class T>
void World<T>::solve_far(const FarRegion& far, const StepSettings<T>& settings, const CutPredicate& cut,
                         StepReport<T>& report) noexcept {
  TACTUS_CHECK(far.bodies.size() == bodies_.size() && far.sub_steps > 0, far.bodies.size(), far.sub_steps);
  TACTUS_CHECK(border_contacts_.empty(), bodies_.size(), border_contacts_.size());
  for (std::uint32_t i = 0; i < bodies_.size(); ++i) held_[i] = frozen_[i] | (far.bodies[i] ^ 1);
  StepSettings<T> fewer = settings;
  fewer.sub_steps = far.sub_steps;
  const T longer = static_cast<T>(settings.sub_steps) / static_cast<T>(far.sub_steps);
  contacts_.scale_impulses_of(far.bodies, longer);
  solve(held_.span(), {}, fewer, T(1), cut, report);
  contacts_.scale_impulses_of(far.bodies, T(1) / longer);
}

template class World<double>;

}  // namespace tactus::physics
