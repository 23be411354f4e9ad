#include "rt/physics/world.h"

#include <algorithm>

#include "rt/physics/collision/collide_parts.h"
#include "rt/physics/collision/mesh_culling.h"
#include "rt/physics/shapes/hull_view.h"

namespace tactus::physics {
namespace {

// Computing a body's bounds takes about 50 ns, handing work to another thread about 1 us.
constexpr std::uint32_t kMinBodies = 64;

std::uint32_t lower_slot(const BoundedVector<Body>& bodies, BodyId id) noexcept {
  const auto* at = std::lower_bound(bodies.begin(), bodies.end(), id, [](const Body& b, BodyId i) { return b.id < i; });
  return static_cast<std::uint32_t>(at - bodies.begin());
}

bool holds(const BoundedVector<Body>& bodies, std::uint32_t slot, BodyId id) noexcept {
  return slot < bodies.size() && bodies[slot].id == id;
}

bool is_compound(const Body& body) noexcept { return body.shape.kind == ShapeKind::kCompound; }

// True if the box may reach below the plane: the half space z <= 0 of its frame.
bool may_cross_plane(const Aabb& box, const BodyFrame& plane) noexcept {
  const Vec3d& normal = plane.axes.z;
  const Vec3d lowest{normal.x > 0.0 ? box.lower.x : box.upper.x, normal.y > 0.0 ? box.lower.y : box.upper.y,
                     normal.z > 0.0 ? box.lower.z : box.upper.z};
  return dot(normal, lowest - plane.position) <= 0.0;
}

}  // namespace

World::World(const Capacities& capacities, const ShapeLists& shapes, const EffectSetups& effects,
             SweepPrecision precision)
    : capacities_(capacities),
      shapes_(shapes),
      bodies_(capacities.bodies),
      fixed_bodies_(capacities.fixed_bodies),
      frozen_(capacities.bodies),
      frozen_in_solve_(capacities.bodies),
      wrenches_(capacities.bodies),
      bounds_(capacities.bodies),
      fixed_bounds_(capacities.fixed_bodies),
      frames_(capacities.bodies),
      fixed_frames_(capacities.fixed_bodies),
      motion_bounds_(capacities.bodies),
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
  const bool scripted = effects_.find<ScriptedMotion>() != nullptr;
  if (precision == SweepPrecision::kSingle && effects_.suit_single_precision())
    single_solver_.emplace(capacities, scripted);
  else
    solver_.emplace(capacities, scripted);
}

bool World::refuse(CapacityBit bit) noexcept {
  refused_bits_ |= bit;
  ++refused_;
  return false;
}

bool World::insert(const Body& body) noexcept {
  const bool fixed = body.kind == BodyKind::kFixed;
  TACTUS_CHECK(body.id < kFirstPatchId, body.id, kFirstPatchId);
  TACTUS_CHECK(is_known(body.shape, fixed, shapes_), static_cast<std::uint32_t>(body.shape.kind), body.shape.index);
  TACTUS_CHECK(is_finite(body.motion.pose) && is_finite(body.motion.velocity), body.id, 0);
  TACTUS_CHECK(fixed || (body.mass > 0.0 && std::isfinite(body.mass)), body.id, body.mass);
  TACTUS_CHECK(
      fixed || (is_finite(body.inertia) && body.inertia.x > 0.0 && body.inertia.y > 0.0 && body.inertia.z > 0.0),
      body.id, body.inertia.x);
  const std::uint32_t slot = lower_slot(bodies_, body.id), fixed_slot = lower_slot(fixed_bodies_, body.id);
  if (holds(bodies_, slot, body.id) || holds(fixed_bodies_, fixed_slot, body.id)) return false;
  if (fixed) {
    if (!fixed_bodies_.try_insert(fixed_slot, body)) return refuse(kFixedBodiesFull);
    static_cast<void>(fixed_bounds_.try_insert(fixed_slot, bounds_of(body.shape, body.motion.pose, 0.0)));
    static_cast<void>(fixed_frames_.try_insert(fixed_slot, BodyFrame::of(body.motion.pose)));
    contacts_.slot_inserted(fixed_slot, true);
    fixed_is_indexed_ = false;
    return true;
  }
  if (!bodies_.try_insert(slot, body)) return refuse(kBodiesFull);
  static_cast<void>(frozen_.try_insert(slot, 0));
  static_cast<void>(wrenches_.try_insert(slot, {}));
  static_cast<void>(last_poses_.try_insert(slot, unknown_pose()));
  contacts_.slot_inserted(slot, false);
  for (auto& spring : springs_)
    if (spring.enabled && number_of(spring.slot) >= slot) spring.slot = SlotIndex{number_of(spring.slot) + 1};
  return true;
}

bool World::remove(BodyId id) noexcept {
  const std::uint32_t slot = lower_slot(bodies_, id), fixed_slot = lower_slot(fixed_bodies_, id);
  if (holds(bodies_, slot, id)) {
    bodies_.erase(slot);
    frozen_.erase(slot);
    wrenches_.erase(slot);
    last_poses_.erase(slot);
    contacts_.slot_removed(slot, false);
    for (auto& spring : springs_) {
      if (spring.enabled && number_of(spring.slot) == slot) spring.enabled = false;
      if (spring.enabled && number_of(spring.slot) > slot) spring.slot = SlotIndex{number_of(spring.slot) - 1};
    }
    return true;
  }
  if (!holds(fixed_bodies_, fixed_slot, id)) return false;
  fixed_bodies_.erase(fixed_slot);
  fixed_bounds_.erase(fixed_slot);
  fixed_frames_.erase(fixed_slot);
  contacts_.slot_removed(fixed_slot, true);
  fixed_is_indexed_ = false;
  return true;
}

std::optional<SlotIndex> World::slot_of(BodyId id) const noexcept {
  const std::uint32_t slot = lower_slot(bodies_, id);
  return holds(bodies_, slot, id) ? std::optional(SlotIndex{slot}) : std::nullopt;
}

Body* World::find(BodyId id) noexcept {
  const std::uint32_t slot = lower_slot(bodies_, id);
  return holds(bodies_, slot, id) ? &bodies_[slot] : nullptr;
}

const Body* World::find(BodyId id) const noexcept { return const_cast<World*>(this)->find(id); }

bool World::add_border_contact(const BorderContact& contact) noexcept {
  return border_contacts_.try_push(contact) || refuse(kBorderContactsFull);
}

WarmStart World::warm_start_of(const Contact& contact, double sub_step_s) noexcept {
  WarmStart out;
  out.key = contact.key;
  out.axis_cache = contact.axis_cache;
  out.count = contact.count;
  const auto [t1, t2] = tangents_of(contact.normal);
  for (std::uint32_t i = 0; i < contact.count; ++i) {
    const ContactPoint& point = contact.points[i];
    out.features[i] = point.feature;
    out.normal_force[i] = point.normal_impulse / sub_step_s;
    out.friction_force[i] = (point.tangent_impulse[0] * t1 + point.tangent_impulse[1] * t2) * (1.0 / sub_step_s);
  }
  return out;
}

void World::apply_wrench(SlotIndex index, const Wrenchd& wrench) noexcept {
  const std::uint32_t slot = number_of(index);
  TACTUS_CHECK(slot < bodies_.size(), slot, bodies_.size());
  wrenches_[slot] += wrench;
  wrench_applied_ = true;
}

void World::apply_impulse(SlotIndex index, const Wrenchd& impulse) noexcept {
  const std::uint32_t slot = number_of(index);
  TACTUS_CHECK(slot < bodies_.size(), slot, bodies_.size());
  if (frozen_[slot] != 0) return;
  Body& body = bodies_[slot];
  const Quatd& q = body.motion.pose.rotation;
  const Vec3d torque = rotate_inverse(q, impulse.torque);
  body.motion.velocity.linear += (1.0 / body.mass) * impulse.force;
  body.motion.velocity.angular +=
      rotate(q, Vec3d{torque.x / body.inertia.x, torque.y / body.inertia.y, torque.z / body.inertia.z});
}

void World::set_frozen(SlotIndex index, bool frozen) noexcept {
  const std::uint32_t slot = number_of(index);
  TACTUS_CHECK(slot < bodies_.size(), slot, bodies_.size());
  frozen_[slot] = frozen ? 1 : 0;
}

void World::begin_step(const StepSettings& settings) noexcept {
  dynamic_pairs_.clear();
  contacts_.clear_pairs();
  index_fixed_bodies();
  const auto count = bodies_.size();
  bounds_.resize(count);
  motion_bounds_.resize(count);
  frames_.resize(count);
  const double fall = fall_ = fall_in_step(settings);
  growth_to_fixed_ = growth_to_fixed(fall, settings);
  const auto measure = [&](std::uint32_t i) noexcept {
    const Body& body = bodies_[i];
    const Twistd& velocity = body.motion.velocity;
    const double radius = bounding_radius(body.shape), linear = norm(velocity.linear), angular = norm(velocity.angular);
    const double own_speed = linear + angular * radius;
    double speed = own_speed;
    for (const auto& spring : springs_)
      if (spring.enabled && number_of(spring.slot) == i) speed = std::max(speed, norm(spring.target_velocity.linear));
    MotionBound& bound = motion_bounds_[i];
    bound = {};
    if (frozen_[i] == 0) {
      bound.moved = speed * settings.dt;
      bound.fallen = std::abs(body.gravity_scale) * fall;
      bound.advance = velocity.linear * settings.dt;
      bound.turn = velocity.angular * settings.dt;
      bound.rest = (speed - linear) * settings.dt;
      bound.driven = (speed - own_speed) * settings.dt;
      const double angle = angular * settings.dt;
      bound.curve = 0.5 * angle * angle * radius;
    }
    measure_motion(last_poses_[i], body.motion.pose, kLargestGap, bound);
    frames_[i] = BodyFrame::of(body.motion.pose);
    const double growth = growth_of(motion_bounds_[i], fall, settings);
    bounds_[i] = bounds_of(body.shape, body.motion.pose, growth, shapes_.hulls);
  };
  executor_.for_each_range(count, kMinBodies, [&](std::uint32_t i, std::uint32_t end) noexcept {
    for (; i < end; ++i) measure(i);
  });
}

void World::add_pairs(StageContext& context) noexcept {
  // A broad phase may report extra pairs; results must not depend on them.
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
  for (const auto& [a, b] : dynamic_pairs_) {
    if (is_compound(bodies_[a]) || is_compound(bodies_[b]))
      add_part_pairs({a, b}, false, context.settings);
    else
      contacts_.add_pair(PairKey::of(bodies_[a].id, bodies_[b].id, false), a, b);
  }
}

// Adds one pair for each two parts whose boxes overlap. `fixed`: b is a slot of the fixed bodies; of a plane, the parts
// that reach it.
void World::add_part_pairs(const SlotPair& pair, bool fixed, const StepSettings& settings) noexcept {
  const Body &a = bodies_[pair.a], &b = fixed ? fixed_bodies_[pair.b] : bodies_[pair.b];
  const auto add = [&](std::uint32_t i, std::uint32_t j) noexcept {
    contacts_.add_pair(PairKey::of(BodyPart{a.id, i}, BodyPart{b.id, j}, fixed), pair.a, pair.b);
  };
  const auto growth_in_step = [&](std::uint32_t slot) noexcept {
    return growth_of(motion_bounds_[slot], fall_, settings);
  };
  const double growth_a = growth_in_step(pair.a) + (fixed ? growth_to_fixed_ : 0.0);
  const double growth_b = fixed ? 0.0 : growth_in_step(pair.b);
  if (b.shape.kind != ShapeKind::kPlane)
    return for_each_near_parts({posed_shape(a), growth_a}, {posed_shape(b), growth_b}, shapes_, add);
  for (std::uint32_t i = 0; i < parts_of(a.shape, shapes_.compounds); ++i) {
    const PosedPart part = part_of(posed_shape(a), i, shapes_.compounds);
    if (may_cross_plane(bounds_of(part.shape, part.pose, growth_a, shapes_.hulls), fixed_frames_[pair.b])) add(i, 0);
  }
}

void World::index_fixed_bodies() noexcept {
  if (fixed_is_indexed_) return;
  fixed_tree_.build(fixed_bounds_.span());
  fixed_is_indexed_ = true;
}

void World::add_fixed_pair(const SlotPair& pair, const StepSettings& settings, StepReport& report) noexcept {
  const auto [f, i] = pair;
  if (fixed_bodies_[f].shape.kind == ShapeKind::kMesh)
    add_mesh_pairs(i, f, settings, report);
  else if (is_compound(bodies_[i]) || is_compound(fixed_bodies_[f]))
    add_part_pairs({i, f}, true, settings);
  else
    contacts_.add_pair(PairKey::of(bodies_[i].id, fixed_bodies_[f].id, true), i, f);
}

// Pairs found by the tree: (fixed slot, moving slot). Pairs beyond the list's capacity are added to the
// contact table at once, which counts what it leaves out.
void World::find_fixed_pairs(const StepSettings& settings, StepReport& report) noexcept {
  fixed_pairs_.clear();
  const auto found = [&](std::uint32_t f, std::uint32_t i) noexcept {
    if (!fixed_pairs_.try_push({f, i})) add_fixed_pair({f, i}, settings, report);
    return true;
  };
  // Bodies that are close together are near few fixed bodies: then one query serves all of them.
  FixedVector<std::uint32_t, 16> near;
  bool few = true;
  if (!bodies_.empty()) {
    Aabb all = bounds_[0];
    for (const Aabb& box : bounds_) all = join(all, box);
    fixed_tree_.find(all.grown(growth_to_fixed_), [&](std::uint32_t f) noexcept { return few = near.try_push(f); });
    std::sort(near.begin(), near.end());
  }
  for (std::uint32_t i = 0; i < bodies_.size(); ++i) {
    if (frozen_[i] != 0) continue;
    const Aabb box = bounds_[i].grown(growth_to_fixed_);
    if (!few) {
      fixed_tree_.find(box, [&](std::uint32_t f) noexcept { return found(f, i); });
      continue;
    }
    for (const std::uint32_t f : near)
      if (fixed_bounds_[f].overlaps(box)) found(f, i);
  }
}

// Sorts the pairs with fixed bodies by their keys, which takes less than sorting what they become. Usually the ids of
// fixed bodies are higher than those of moving ones, and the pairs are in order as they were found.
void World::sort_fixed_pairs() noexcept {
  const auto key_of = [this](const SlotPair& pair) noexcept {
    const Body& fixed = fixed_bodies_[pair.a];
    const bool is_mesh = fixed.shape.kind == ShapeKind::kMesh;
    return PairKey::of(bodies_[pair.b].id, is_mesh ? shapes_.meshes[fixed.shape.index].first_patch_id : fixed.id, true);
  };
  const auto before = [&](const SlotPair& p, const SlotPair& q) noexcept { return key_of(p) < key_of(q); };
  if (!std::is_sorted(fixed_pairs_.begin(), fixed_pairs_.end(), before))
    std::sort(fixed_pairs_.begin(), fixed_pairs_.end(), before);
}

// Adds the pairs in the order of their keys. Planes are in no tree.
void World::add_fixed_pairs(StageContext& context) noexcept {
  mesh_triangles_.clear();
  find_fixed_pairs(context.settings, context.report);
  context.pairs = &fixed_pairs_;
  effects_.stages().run(Phase::kFixedPairs, context);
  for (const std::uint32_t f : fixed_tree_.unbounded())
    for (std::uint32_t i = 0; i < bodies_.size(); ++i) {
      if (frozen_[i] != 0 || !may_cross_plane(bounds_[i].grown(growth_to_fixed_), fixed_frames_[f])) continue;
      if (!fixed_pairs_.try_push({f, i})) add_fixed_pair({f, i}, context.settings, context.report);
    }
  sort_fixed_pairs();
  for (const SlotPair& pair : fixed_pairs_) add_fixed_pair(pair, context.settings, context.report);
}

// Adds one pair for each part of the body and each patch near it, with the patch's triangles.
void World::add_mesh_pairs(std::uint32_t slot, std::uint32_t fixed_slot, const StepSettings& settings,
                           StepReport& report) noexcept {
  const Body &body = bodies_[slot], &fixed = fixed_bodies_[fixed_slot];
  const Posed mesh_from_body = relative_pose(fixed.motion.pose, body.motion.pose);
  std::uint32_t left_out = 0;
  for (std::uint32_t i = 0; i < parts_of(body.shape, shapes_.compounds); ++i) {
    const PosedPart part = part_of({body.shape, mesh_from_body}, i, shapes_.compounds);
    left_out += add_patch_pairs(part, {body.id, i}, slot, fixed_slot, settings);
  }
  if (left_out == 0) return;
  report.capacity_bits |= kMeshTrianglesFull;
  report.dropped += left_out;
}

// `part`: in the mesh's frame. Returns the number of triangles that did not fit.
std::uint32_t World::add_patch_pairs(const PosedPart& part, BodyPart of, std::uint32_t slot, std::uint32_t fixed_slot,
                                     const StepSettings& settings) noexcept {
  const Body& fixed = fixed_bodies_[fixed_slot];
  const Mesh& mesh = shapes_.meshes[fixed.shape.index];
  const double reach = margin_to_fixed(motion_bounds_[slot], settings);
  const Aabb box = bounds_of(part.shape, part.pose, reach, shapes_.hulls);
  const MeshCulling culling(mesh, part, motion_bounds_[slot], fixed.motion.pose.rotation, settings, shapes_.hulls);
  TriangleList near;
  BodyOnMesh body_on_mesh(mesh, part.posed(), reach, shapes_.hulls);
  near_triangles.find(mesh, of.body, fixed.shape.index, box, near, &body_on_mesh);
  std::uint32_t left_out = near.left_out;
  PatchTriangles stretch{mesh_triangles_.size(), 0};
  std::uint32_t patch = 0;
  const auto add_pair = [&]() noexcept {
    if (stretch.count > 0)
      contacts_.add_pair(PairKey::of(of, BodyPart{mesh.first_patch_id + patch, 0}, true), slot, fixed_slot, stretch);
    stretch = {mesh_triangles_.size(), 0};
  };
  for (const std::uint32_t triangle : near.triangles) {
    if (!culling.can_touch(triangle)) continue;
    if (mesh.triangles[triangle].patch != patch) {
      add_pair();
      patch = mesh.triangles[triangle].patch;
    }
    if (mesh_triangles_.try_push(triangle))
      ++stretch.count;
    else
      ++left_out;
  }
  add_pair();
  return left_out;
}

StepReport World::finish_step(const StepSettings& settings, const CutPredicate& cut,
                              const CoarseRegion& coarse) noexcept {
  TACTUS_CHECK(settings.sub_steps > 0 && settings.dt > 0.0, settings.sub_steps, settings.dt);
  TACTUS_CHECK(bounds_.size() == bodies_.size(), bounds_.size(), bodies_.size());
  StepReport report;
  report.capacity_bits = refused_bits_;
  report.dropped = refused_;
  refused_bits_ = 0;
  refused_ = 0;
  const double h = settings.dt / static_cast<double>(settings.sub_steps);
  const double impulse_scale = last_sub_step_ > 0.0 && last_sub_step_ != h ? h / last_sub_step_ : 1.0;
  last_sub_step_ = h;

  StageContext context{.bodies = bodies_.span(),
                       .fixed_bodies = fixed_bodies_.span(),
                       .frozen = frozen_.span(),
                       .contacts = {},
                       .settings = settings,
                       .report = report,
                       .executor = executor_};
  add_pairs(context);
  add_fixed_pairs(context);
  contacts_.build({.bodies = bodies_.span(),
                   .fixed_bodies = fixed_bodies_.span(),
                   .frames = frames_.span(),
                   .fixed_frames = fixed_frames_.span(),
                   .motion_bounds = motion_bounds_.span(),
                   .shapes = shapes_,
                   .mesh_triangles = mesh_triangles_.span()},
                  settings, h, impulse_scale, report, executor_);
  for (std::uint32_t i = 0; i < bodies_.size(); ++i) last_poses_[i] = bodies_[i].motion.pose;
  if (coarse.bodies.empty()) {
    solve(frozen_.span(), springs_, settings, impulse_scale, cut, report);
  } else {
    frozen_in_solve_.resize(bodies_.size());
    for (std::uint32_t i = 0; i < bodies_.size(); ++i) frozen_in_solve_[i] = frozen_[i] | coarse.bodies[i];
    solve(frozen_in_solve_.span(), springs_, settings, impulse_scale, cut, report);
    solve_coarse(coarse, settings, cut, report);
  }
  if (wrench_applied_)
    for (Wrenchd& wrench : wrenches_) wrench = {};
  wrench_applied_ = false;
  return report;
}

// `frozen`, by slot: 1: the body neither moves nor takes impulses.
void World::solve(std::span<const std::uint8_t> frozen, std::span<PoseSpring> springs, const StepSettings& settings,
                  double impulse_scale, const CutPredicate& cut, StepReport& report) noexcept {
  const std::span<const Wrenchd> wrenches =
      wrench_applied_ ? std::span<const Wrenchd>(wrenches_.span()) : std::span<const Wrenchd>();
  const SolverInput input{.bodies = bodies_.span(),
                          .frozen = frozen,
                          .wrenches = wrenches,
                          .contacts = contacts_.contacts(),
                          .springs = springs,
                          .border = border_contacts_.span(),
                          .ghosts = border_ghosts_.span(),
                          .border_rule = border_rule,
                          .impulse_scale = impulse_scale,
                          .stages = effects_.stages(),
                          .fixed_bodies = fixed_bodies_.span(),
                          .executor = executor_};
  if (solver_) return solver_->step(input, settings, cut, report);
  TACTUS_CHECK(border_contacts_.empty(), bodies_.size(), border_contacts_.size());
  single_solver_->step(input, settings, cut, report);
}

// Solves the coarse region. The other bodies have been solved and are frozen. Between steps, contacts store impulses of
// the other bodies' sub-step; those of the coarse region are converted before and after.
void World::solve_coarse(const CoarseRegion& coarse, const StepSettings& settings, const CutPredicate& cut,
                         StepReport& report) noexcept {
  TACTUS_CHECK(coarse.bodies.size() == bodies_.size() && coarse.sub_steps > 0, coarse.bodies.size(), coarse.sub_steps);
  TACTUS_CHECK(border_contacts_.empty(), bodies_.size(), border_contacts_.size());
  for (std::uint32_t i = 0; i < bodies_.size(); ++i) frozen_in_solve_[i] = frozen_[i] | (coarse.bodies[i] ^ 1);
  StepSettings fewer = settings;
  fewer.sub_steps = coarse.sub_steps;
  const double longer = static_cast<double>(settings.sub_steps) / static_cast<double>(coarse.sub_steps);
  contacts_.scale_impulses_of(coarse.bodies, longer);
  solve(frozen_in_solve_.span(), {}, fewer, 1.0, cut, report);
  contacts_.scale_impulses_of(coarse.bodies, 1.0 / longer);
}

}  // namespace tactus::physics
