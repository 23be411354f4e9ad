#include "tools/validation/random_trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "rt/physics/overlap.h"
#include "sim/loader/scene_load.h"
#include "tools/validation/case_world.h"
#include "tools/validation/draw.h"
#include "tools/validation/random_world.h"

namespace tactus::hard_cases {
namespace {

using physics::Aabb;
using physics::Body;
using physics::BodyKind;
using physics::ShapeKind;

constexpr std::uint64_t kHandSeed =
    0x68616e64;                       // separate seed, so that the hand does not depend on the draws of the world
constexpr double kArm_N_per_m = 400;  // HandScript's default; in series with the coupling
constexpr double kSmallestProxy_m = 1e-3, kLargestProxy_m = 0.03;
constexpr double kClear_m = 1e-4;           // m, clearance between proxy and ground at the start
constexpr std::uint32_t kFirstPlane = 100;  // ids of the planes that are added
constexpr double kAtRest_m_per_s = experiment::StandingRule::kAtRest_m_per_s;

Aabb box_of(const Body& body) { return bounds_of(body.shape, body.motion.pose, 0.0); }

// Sets velocities to zero and adds a ground and, in every other world, four walls, some closer than its bodies need.
// Otherwise the bodies fly apart and none is left standing. No body is larger than the space between the walls.
RandomWorld calmed(RandomWorld world, Draw& random) {
  double half_width = 0, largest = 0;
  bool grounded = false;
  for (Body& body : world.bodies) {
    body.motion.velocity = {};
    grounded = grounded || body.shape.kind == ShapeKind::kPlane;
    if (body.kind != BodyKind::kDynamic) continue;
    const Aabb box = box_of(body);
    largest = std::max(largest, bounding_radius(body.shape));
    half_width = std::max({half_width, box.upper.x, box.upper.y, -box.lower.x, -box.lower.y});
  }
  const auto add_plane = [&](const Posed& pose, double friction) {
    world.bodies.push_back(physics::make_fixed_body(static_cast<BodyId>(kFirstPlane + world.bodies.size()),
                                                    physics::Shape::plane(), friction, pose));
  };
  if (!grounded) add_plane({}, random.uniform(0, 1));
  if (random.chance(0.5)) return world;
  const double at = std::max(half_width * random.uniform(0.5, 1), largest), friction = random.uniform(0, 1);
  for (const Vec3d way : {Vec3d{1, 0, 0}, Vec3d{-1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, -1, 0}})  // normals point inwards
    add_plane({-at * way, quat_from_rotation_vector(0.5 * kPi * cross(Vec3d{0, 0, 1}, way))}, friction);
  return world;
}

// Returns a body at rest, if there is one.
const Body& chosen_body(const RandomWorld& world, Draw& random) {
  std::vector<const Body*> moving, resting;
  for (const Body& body : world.bodies) {
    if (body.kind != BodyKind::kDynamic) continue;
    moving.push_back(&body);
    if (norm(body.motion.velocity.linear) < kAtRest_m_per_s) resting.push_back(&body);
  }
  const auto& among = resting.empty() ? moving : resting;
  return *among[random.below(static_cast<std::uint32_t>(among.size()))];
}

// Signed distance from a point to a body's surface; negative inside. Exact outside for spheres, capsules, boxes and
// planes.
double distance_to(const Body& body, const Vec3d& point) {
  const Posed& pose = body.motion.pose;
  const Vec3d p = rotate_inverse(pose.rotation, point - pose.position);
  const auto& shape = body.shape;
  switch (shape.kind) {
    case ShapeKind::kPlane:
      return p.z;
    case ShapeKind::kBox: {
      const Vec3d q{std::abs(p.x) - shape.half_extents.x, std::abs(p.y) - shape.half_extents.y,
                    std::abs(p.z) - shape.half_extents.z};
      return norm(Vec3d{std::max(q.x, 0.0), std::max(q.y, 0.0), std::max(q.z, 0.0)}) +
             std::min(0.0, std::max({q.x, q.y, q.z}));
    }
    default: {  // sphere: a capsule of length 0
      const Vec3d on_axis{0, 0, std::clamp(p.z, -shape.half_length, shape.half_length)};
      return norm(p - on_axis) - shape.radius;
    }
  }
}

// Centre of a ball, moved from outside towards `at` along -`out`, at which it first touches a body: sphere tracing
// (Hart 1996).
Vec3d first_touch(const RandomWorld& world, const Vec3d& at, const Vec3d& out, double radius) {
  double along = 0;
  for (const Body& body : world.bodies)
    if (body.shape.kind != ShapeKind::kPlane)
      along = std::max(along, dot(body.motion.pose.position - at, out) + bounding_radius(body.shape) + radius);
  constexpr int kSteps = 1000;
  constexpr double kTouches_m = 1e-7;
  for (int k = 0; k < kSteps; ++k) {
    double free = along;
    for (const Body& body : world.bodies)
      if (body.shape.kind != ShapeKind::kPlane) free = std::min(free, distance_to(body, at + along * out) - radius);
    if (free < kTouches_m) break;
    along -= free;
  }
  return at + along * out;
}

ScriptedHand random_hand(const RandomWorld& world, Draw& random) {
  const Body& body = chosen_body(world, random);
  const Aabb box = box_of(body);
  const Vec3d half = 0.5 * (box.upper - box.lower);
  ScriptedHand hand;
  hand.radius_m =
      std::clamp(random.logarithmic(0.1, 1) * std::min({half.x, half.y, half.z}), kSmallestProxy_m, kLargestProxy_m);
  hand.mass_kg = random.logarithmic(0.05, 0.5);
  hand.friction = random.uniform(0, 1);
  hand.stiffness_N_per_m = random.logarithmic(200, 1500);
  constexpr Vec3d kWays[]{// half of them from above
                          {0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}};
  const auto planes = std::count_if(world.bodies.begin(), world.bodies.end(),
                                    [](const auto& b) { return b.shape.kind == ShapeKind::kPlane; });
  const Vec3d out = kWays[random.below(planes > 1 ? 3 : std::size(kWays))];  // between walls from above
  Vec3d at = body.motion.pose.position;
  for (int k = 0; k < 3; ++k) at[k] += random.uniform(-0.4, 0.4) * half[k];
  for (const Body& plane : world.bodies)  // the proxy begins on the free side of ground and walls
    if (plane.shape.kind == ShapeKind::kPlane)
      at += std::max(0.0, hand.radius_m + kClear_m - distance_to(plane, at)) *
            rotate(plane.motion.pose.rotation, Vec3d{0, 0, 1});
  const double gap = random.logarithmic(0.5e-3, 5e-3);
  const Vec3d start = first_touch(world, at, out, hand.radius_m) + gap * out;
  const double stiffness = 1 / (1 / hand.stiffness_N_per_m + 1 / kArm_N_per_m);
  const Vec3d in = start - (gap + random.logarithmic(0.3, 15) / stiffness) * out;
  const Vec3d side = random.logarithmic(0.5e-3, 20e-3) * (out.z != 0 ? Vec3d{1, 0, 0} : Vec3d{0, 0, 1});
  hand.path = {{0, start},       {0.5, in}, {1, in},      {1.5, in + side}, {2, in - side},
               {2.5, in + side}, {3, in},   {3.4, start}, {3.6, in},        {kTrial_s, in}};
  return hand;
}

experiment::WholeRunRequest request_of(sim::Scene scene, const experiment::Scheme& scheme) {
  experiment::WholeRunRequest request;
  request.scenes.push_back(std::move(scene));
  request.schemes = {scheme};
  request.seconds = kTrial_s;
  request.keep_bodies = true;
  return request;
}

sim::Scene shaken(sim::Scene scene, Draw& random) {
  for (Body& body : scene.bodies)
    if (body.kind == BodyKind::kDynamic) body.motion.pose.position += random.vector(CollapseRule::kApart_m);
  return scene;
}

double overlap_at_start(const RandomWorld& random) {
  CaseWorld world({}, random.contact_hertz);
  for (const Body& body : random.bodies) world.add(body);
  world.step();
  return physics::deepest_overlap(world.world).share;
}

bool contains(const std::vector<BodyId>& ids, BodyId id) { return std::find(ids.begin(), ids.end(), id) != ids.end(); }

std::vector<BodyId> stood_still(const std::vector<BodyId>& among, const experiment::WholeRunRow& row) {
  const auto moved = experiment::judge_standing(row.start, row.start, row.direct_end).fell;
  std::vector<BodyId> still;
  for (const Body& body : row.start)
    if (contains(among, body.id) && norm(body.motion.velocity.linear) <= kAtRest_m_per_s && !contains(moved, body.id))
      still.push_back(body.id);
  return still;
}

}  // namespace

double RandomTrial::gain() const noexcept {
  return (row.energy_gain_J - row.direct_energy_gain_J) / (row.energy_at_play_J + row.direct_kinetic_J);
}

std::vector<BodyId> fallen_beside_all(const experiment::WholeRunRow& row,
                                      std::span<const experiment::WholeRunRow> others) {
  using experiment::judge_standing;
  std::vector<BodyId> fell = judge_standing(row.start, row.direct_end, row.end).fell;
  for (const auto& other : others) {
    const auto here = judge_standing(other.start, other.direct_end, row.end).fell;
    const auto differ = judge_standing(row.start, row.direct_end, other.direct_end).fell;
    std::erase_if(fell, [&](BodyId id) { return !contains(here, id) || contains(differ, id); });
  }
  return fell;
}

bool worse(const RandomTrial& a, const RandomTrial& b) noexcept {
  const auto rank = [](const RandomTrial& trial) {
    const double off = trial.row.pose_off_share / experiment::StandingRule::kShareOfExtent;
    return std::tuple(trial.still_falls(), trial.collapses(), std::max(off, trial.gain() / CollapseRule::kMaxGain));
  };
  return rank(a) > rank(b);
}

Result<RandomTrial> try_random_world(std::uint64_t seed) {
  Draw random(seed ^ kHandSeed);
  const RandomWorld world = settled(calmed(make_random_world(seed), random), kTrialSettles_s);
  const ScriptedHand hand = random_hand(world, random);
  const auto moving = std::count_if(world.bodies.begin(), world.bodies.end(),
                                    [](const auto& body) { return body.kind == BodyKind::kDynamic; });
  const unsigned members = 2 + random.below(std::max(1u, static_cast<std::uint32_t>(moving) / 2));  // proxy included
  RandomTrial trial;
  trial.seed = seed;
  trial.scene = to_scene(world, fmt::format("# Random world {} after {:g} s, with a hand.\n", seed, kTrialSettles_s),
                         hand, members);
  auto parsed = sim::parse_scene(trial.scene, fmt::format("random-world-{}", seed));
  if (!parsed.ok()) return parsed.status();
  const sim::Scene& scene = parsed.value();
  for (const Body& body : scene.bodies)
    if (body.kind == BodyKind::kFixed) trial.fixed.push_back(body);
  trial.start_overlap = overlap_at_start(world);
  auto rows = experiment::run_whole(request_of(scene, {.ratio = kTrialRatio}), {});
  if (!rows.ok()) return rows.status();
  trial.row = std::move(rows.value().front());
  const auto& row = trial.row;
  if (row.fallen == 0) return trial;
  std::vector<experiment::WholeRunRow> others;
  for (const sim::Scene& other :
       {shaken(scene, random), experiment::with_finer_steps(scene, CollapseRule::kFinerSteps)}) {
    auto direct = experiment::run_whole(request_of(other, experiment::kDirectScheme), {});
    if (!direct.ok()) return direct.status();
    others.push_back(std::move(direct.value().front()));
  }
  trial.fell = fallen_beside_all(row, others);
  trial.still = stood_still(trial.fell, row);
  return trial;
}

}  // namespace tactus::hard_cases
