#include "sim/loader/scene_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "rt/base/rotation_vector.h"
#include "rt/physics/collision/collide_mesh.h"
#include "rt/physics/collision/collide_parts.h"
#include "rt/physics/collision/manifold.h"
#include "rt/physics/shapes/mesh_query.h"
#include "rt/physics/step.h"
#include "sim/broad_phase/pair_grid.h"
#include "sim/loader/body_label.h"
#include "sim/model/rounded_down.h"
#include "sim/model/scene_effects.h"
#include "sim/model/step_settings.h"
#include "sim/model/world_capacities.h"

namespace tactus::sim {
namespace {

using physics::Body;
using physics::BodyKind;
using physics::ShapeKind;

constexpr double kMaxOverlapAtStart_m = 1e-4;
constexpr double kMargin_m = physics::StepSettings{}.min_margin;  // bodies closer than this touch at the start
constexpr double kTwoPi = 6.28318530717958647692;

BodyCounts count_bodies(const Scene& scene) {
  BodyCounts counts;
  for (const auto& body : scene.bodies) {
    ++counts.total;
    ++(body.kind == BodyKind::kFixed ? counts.fixed : counts.dynamic);
    switch (body.shape.kind) {
      case ShapeKind::kBox:
        ++counts.boxes;
        break;
      case ShapeKind::kSphere:
        ++counts.spheres;
        break;
      case ShapeKind::kCapsule:
        ++counts.capsules;
        break;
      case ShapeKind::kCylinder:
        ++counts.cylinders;
        break;
      case ShapeKind::kCone:
        ++counts.cones;
        break;
      case ShapeKind::kPlane:
        ++counts.planes;
        break;
      case ShapeKind::kHull:
        ++counts.hulls;
        break;
      case ShapeKind::kMesh:
        ++counts.meshes;
        break;
      case ShapeKind::kCompound:
        ++counts.compounds;
        counts.parts += physics::parts_of(body.shape, scene.compounds);
        break;
    }
  }
  return counts;
}

std::vector<EffectReport> report_effects(const Scene& scene) {
  std::vector<EffectReport> reports;
  for (const auto& effect : known_effects())
    reports.push_back({.name = std::string(effect.name),
                       .declared = scene.effects.*effect.declared,
                       .used = is_in_use(scene, effect),
                       .cost = std::string(effect.cost)});
  return reports;
}

void count_contact(const physics::Manifold& manifold, BodyId a, BodyId b, StartContacts& start) {
  if (manifold.count == 0) return;
  ++start.contacts;
  start.points += manifold.count;
  for (std::uint32_t i = 0; i < manifold.count; ++i) {
    if (-manifold.points[i].separation <= start.deepest_m) continue;
    start.deepest_m = -manifold.points[i].separation;
    start.deepest_a = a;
    start.deepest_b = b;
  }
}

// Counts the contacts of one part of a body with a mesh, patch by patch.
void add_mesh_contacts(const Scene& scene, const physics::PosedShape& part, BodyId id, const Body& b,
                       StartContacts& start) {
  const auto& mesh = scene.meshes[b.shape.index];
  physics::TriangleList near;
  const Posed mesh_from_part = physics::relative_pose(b.motion.pose, part.pose);
  physics::BodyOnMesh touch(mesh, {part.shape, mesh_from_part}, kMargin_m, scene.hulls);
  const auto box = physics::bounds_of(part.shape, mesh_from_part, kMargin_m, scene.hulls);
  physics::find_triangles(mesh, box, near, &touch);
  if (near.left_out > start.triangles_left_out) {
    start.triangles_left_out = near.left_out;
    start.fine_body = id;
    start.fine_mesh = b.id;
  }
  const auto triangles = near.triangles.span();
  const auto patch_of = [&](std::size_t i) { return mesh.triangles[triangles[i]].patch; };
  for (std::size_t first = 0, end = 0; first < triangles.size(); first = end) {
    while (end < triangles.size() && patch_of(end) == patch_of(first)) ++end;
    const physics::PosedPatch patch{
        .mesh = mesh, .world_from_mesh = b.motion.pose, .triangles = triangles.subspan(first, end - first)};
    count_contact(physics::collide_patch(part, patch, {.margin = kMargin_m}, scene.hulls), id, b.id, start);
  }
}

// Counts the contacts of one pair, a before b by id.
void add_contacts_of(const Scene& scene, const Body& a, const Body& b, StartContacts& start) {
  if (b.shape.kind == ShapeKind::kMesh) {
    for (std::uint32_t i = 0; i < physics::parts_of(a.shape, scene.compounds); ++i)
      add_mesh_contacts(scene, part_of(posed_shape(a), i, scene.compounds).posed(), a.id, b, start);
    return;
  }
  physics::for_each_manifold(
      posed_shape(a), posed_shape(b), kMargin_m, scene.shapes(),
      [&](std::uint32_t, std::uint32_t, const auto& manifold) noexcept { count_contact(manifold, a.id, b.id, start); });
}

void add_contact(const Scene& scene, const Body& a, const Body& b, StartContacts& start) {
  const unsigned before = start.contacts;
  add_contacts_of(scene, a, b, start);
  if (start.contacts - before <= start.most) return;
  start.most = start.contacts - before;
  start.most_a = a.id;
  start.most_b = b.id;
}

// Pairs that a joint keeps from colliding, the lower id first, sorted.
std::vector<std::pair<BodyId, BodyId>> joined_pairs(const Scene& scene) {
  std::vector<std::pair<BodyId, BodyId>> pairs;
  for (const auto& joint : scene.effect_data.joints)
    if (!joint.bodies_collide) pairs.emplace_back(std::min(joint.a, joint.b), std::max(joint.a, joint.b));
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

StartContacts find_start_contacts(const Scene& scene) {
  const auto joined = joined_pairs(scene);
  const auto are_joined = [&joined](const Body& a, const Body& b) {
    return std::binary_search(joined.begin(), joined.end(), std::pair(std::min(a.id, b.id), std::max(a.id, b.id)));
  };
  std::vector<const Body*> dynamic, fixed;
  std::vector<physics::Aabb> bounds;
  for (const auto& body : scene.bodies) {
    (body.kind == BodyKind::kFixed ? fixed : dynamic).push_back(&body);
    if (body.kind != BodyKind::kFixed) bounds.push_back(bounds_of(body.shape, body.motion.pose, 0.5 * kMargin_m));
  }
  StartContacts start;
  if (dynamic.empty()) return start;
  // 64 neighbours a body: more than convex bodies of similar size can have; pairs that do not fit are not counted.
  BoundedVector<physics::SlotPair> pairs(static_cast<std::uint32_t>(64 * dynamic.size()));
  PairGrid grid(static_cast<std::uint32_t>(dynamic.size()));
  (void)grid.find(bounds, pairs);
  std::sort(pairs.begin(), pairs.end(), [](const auto& p, const auto& q) {
    return std::pair(std::min(p.a, p.b), std::max(p.a, p.b)) < std::pair(std::min(q.a, q.b), std::max(q.a, q.b));
  });
  for (const auto& pair : pairs) {
    const Body &a = *dynamic[std::min(pair.a, pair.b)], &b = *dynamic[std::max(pair.a, pair.b)];
    if (!are_joined(a, b)) add_contact(scene, a, b, start);
  }
  for (const auto* f : fixed) {
    const auto box = bounds_of(f->shape, f->motion.pose, 0.5 * kMargin_m);
    for (std::size_t i = 0; i < dynamic.size(); ++i)
      if (box.overlaps(bounds[i]) && !are_joined(*dynamic[i], *f)) add_contact(scene, *dynamic[i], *f, start);
  }
  return start;
}

// The largest speed between two way points, by the kind of motion. `way`: the displacement. `v_a`, `v_b`: the
// velocities at its ends, for a cubic, whose velocity is a parabola: sampled at seventeen points.
double fastest_between(haptics::HandMotion motion, const Vec3d& way, double time_s, const Vec3d& v_a,
                       const Vec3d& v_b) {
  if (motion == haptics::HandMotion::kSmoothStep) return 15.0 / 8.0 * norm(way) / time_s;
  if (motion == haptics::HandMotion::kLinear) return norm(way) / time_s;
  double fastest = 0;
  for (int i = 0; i <= 16; ++i) {
    const double u = i / 16.0;
    fastest = std::max(
        fastest, norm(way * (6 * u * (1 - u) / time_s) + v_a * ((1 - u) * (1 - 3 * u)) + v_b * (u * (3 * u - 2))));
  }
  return fastest;
}

const char* word_of(haptics::HandMotion motion) {
  switch (motion) {
    case haptics::HandMotion::kLinear:
      return "linear";
    case haptics::HandMotion::kCubic:
      return "cubic";
    case haptics::HandMotion::kSmoothStep:
      break;
  }
  return "smooth step";
}

HandReport report_hand(const Scene& scene, const haptics::DeviceProperties& device) {
  HandReport report;
  report.device_max_speed_m_per_s = device.max_speed_m_per_s;
  report.device_max_angular_speed_rad_per_s = device.max_angular_speed_rad_per_s;
  report.workspace_radius_m = device.workspace_radius_m;
  const auto& path = scene.hand.path;
  if (path.empty()) return report;
  report.file = scene.hand.file;
  report.motion = word_of(scene.hand.motion);
  report.points = path.size();
  report.duration_s = path.back().time_s;
  const Vec3d middle = scene.device.world_from_device.position;
  const auto note = [](double value, double& most, std::size_t i, std::size_t& at) {
    if (value > most) {
      most = value;
      at = i;
    }
  };
  for (std::size_t i = 0; i < path.size(); ++i) {
    note(norm(path[i].position_m - middle) / scene.device.motion_scale, report.farthest_m, i, report.farthest);
    if (i == 0) continue;
    const ScriptWaypoint &a = path[i - 1], &b = path[i];
    const double time_s = b.time_s - a.time_s;
    note(fastest_between(scene.hand.motion, b.position_m - a.position_m, time_s, a.velocity_m_per_s,
                         b.velocity_m_per_s) /
             scene.device.motion_scale,
         report.max_speed_m_per_s, i, report.fastest);
    const Vec3d turn = rotation_vector_of(quat_from_rotation_vector(b.rotation_vector_rad) *
                                          conjugate(quat_from_rotation_vector(a.rotation_vector_rad)));
    note(fastest_between(scene.hand.motion, turn, time_s, a.angular_velocity_rad_per_s, b.angular_velocity_rad_per_s),
         report.max_angular_speed_rad_per_s, i, report.fastest_turn);
  }
  return report;
}

// The position of a way point or row in the text, for messages: "[hand] path.3", or the line of the motion file.
std::string hand_place(const HandReport& hand, std::size_t i) {
  return hand.file.empty() ? fmt::format("[hand] path.{}", i + 1)
                           : fmt::format("[hand] file {}:{}:", hand.file, i + kFirstMotionLine);
}

void find_problems(const Scene& scene, bool device_rotates, SceneReport& report) {
  const auto problem = [&report](std::string text) { report.problems.push_back(std::move(text)); };
  if (!report.coupling.accepted) {
    const auto axis = [&](const char* name, const haptics::AxisVerdict& verdict, const char* unit,
                          const char* stiffness, const char* damping) {
      if (verdict.accepted) return;
      problem(fmt::format("[coupling] {}: {:g} {} with damping {:g}; accepted: {} at most {:.4g}, {} at most {:.4g}",
                          name, verdict.stiffness, unit, verdict.damping, stiffness,
                          rounded_down(verdict.stiffness_allowed), damping, rounded_down(verdict.damping_limit)));
    };
    axis("translation", report.coupling.translation, "N/m", "stiffness_N_per_m", "damping_Ns_per_m");
    axis("rotation", report.coupling.rotation, "N m/rad", "stiffness_Nm_per_rad", "damping_Nms_per_rad");
  }
  if (report.start.deepest_m > kMaxOverlapAtStart_m)
    problem(fmt::format("{} and {} overlap by {:.4g} m at the start; accepted: at most {:g} m",
                        body_label(scene, report.start.deepest_a), body_label(scene, report.start.deepest_b),
                        report.start.deepest_m, kMaxOverlapAtStart_m));
  if (report.start.contacts > report.capacity.global_contacts)
    problem(
        fmt::format("{} contacts at the start, {} of them between {} and {}; accepted: at most {}, beyond which the "
                    "shallowest are left out (give these bodies fewer parts, or move them apart)",
                    report.start.contacts, report.start.most, body_label(scene, report.start.most_a),
                    body_label(scene, report.start.most_b), report.capacity.global_contacts));
  if (report.start.triangles_left_out > 0)
    problem(fmt::format(
        "{} can touch too many triangles of {} at the start; accepted: at most {}, beyond which those nearest "
        "to its middle are kept (make this ground flat or of larger triangles, or the body a compound)",
        body_label(scene, report.start.fine_body), body_label(scene, report.start.fine_mesh),
        physics::kMaxBodyTriangles));
  const HandReport& hand = report.hand;
  if (hand.farthest_m > hand.workspace_radius_m)
    problem(
        fmt::format("{} leaves the device's workspace: {:.3g} m from its middle; accepted: at most {:g} m "
                    "(move [device], or raise motion_scale)",
                    hand_place(hand, hand.farthest), hand.farthest_m, hand.workspace_radius_m));
  if (hand.max_speed_m_per_s > hand.device_max_speed_m_per_s)
    problem(fmt::format("{} asks for {:.3g} m/s; accepted: at most {:g} m/s, what the device can do",
                        hand_place(hand, hand.fastest), hand.max_speed_m_per_s, hand.device_max_speed_m_per_s));
  if (device_rotates && hand.max_angular_speed_rad_per_s > hand.device_max_angular_speed_rad_per_s)
    problem(fmt::format("{} asks for {:.3g} rad/s; accepted: at most {:g} rad/s, what the device can do",
                        hand_place(hand, hand.fastest_turn), hand.max_angular_speed_rad_per_s,
                        hand.device_max_angular_speed_rad_per_s));
  if (scene.solver.contact_hertz > report.max_contact_hertz_Hz)
    problem(fmt::format("contact_hertz_Hz: {:g} at this rate; accepted: at most {:g}", scene.solver.contact_hertz,
                        report.max_contact_hertz_Hz));
}

}  // namespace

SceneReport report_on(const Scene& scene, const haptics::DeviceProperties& device, double tick_s, bool scripted) {
  SceneReport report;
  report.name = scene.name;
  report.title = scene.title;
  report.bodies = count_bodies(scene);
  report.effects = report_effects(scene);
  report.generated = scene.generated;
  report.meshes = scene.mesh_accounts;
  report.lightest_kg = std::numeric_limits<double>::infinity();
  const auto follows_script = [&](BodyId id) {  // its mass has no effect
    return std::any_of(scene.effect_data.scripts.begin(), scene.effect_data.scripts.end(),
                       [id](const auto& script) { return script.id == id; });
  };
  for (const auto& body : scene.bodies) {
    if (body.kind == BodyKind::kFixed || follows_script(body.id)) continue;
    report.lightest_kg = std::min(report.lightest_kg, body.mass);
    report.heaviest_kg = std::max(report.heaviest_kg, body.mass);
  }
  report.mass_ratio = report.heaviest_kg / report.lightest_kg;

  report.contact_hertz_Hz = scene.solver.contact_hertz;
  report.max_contact_hertz_Hz = max_contact_hertz(scene.solver, tick_s);
  const double omega = kTwoPi * scene.solver.contact_hertz;
  report.penetration = {1 / (scene.bodies[scene.proxy].mass * omega * omega), 1 / (report.lightest_kg * omega * omega)};

  const double s2 = scene.device.motion_scale * scene.device.motion_scale;
  report.coupling = haptics::check_coupling(scene.coupling.at_hand(scene.device.motion_scale), device, tick_s);
  haptics::AxisVerdict& linear = report.coupling.translation;  // converted to the units of the scene's keys
  for (double* value :
       {&linear.stiffness, &linear.stiffness_limit, &linear.stiffness_allowed, &linear.damping, &linear.damping_limit})
    *value /= s2;
  if (scripted) report.hand = report_hand(scene, device);
  report.start = find_start_contacts(scene);
  report.capacity.member_cap = scene.members;
  report.capacity.members_possible = std::min(scene.members, report.bodies.dynamic);
  report.capacity.contacts_per_body = static_cast<double>(report.start.contacts) / std::max(1u, report.bodies.dynamic);
  report.capacity.sub_world_contacts =
      static_cast<unsigned>(std::ceil(report.capacity.contacts_per_body * report.capacity.members_possible));
  report.capacity.global_contacts = capacities_for(scene).contacts;
  report.capacity.global_sub_steps = global_step(scene, scene.ratio, scene.solver.sub_steps, true).sub_steps;
  find_problems(scene, device.has_rotation, report);
  return report;
}

}  // namespace tactus::sim
