#include "tools/validation/random_world.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/validation/case_world.h"
#include "tools/validation/draw.h"

namespace tactus::hard_cases {
namespace {

using physics::Body;
using physics::BodyKind;
using physics::Shape;
using physics::ShapeKind;

constexpr double kSmallest_m = 1e-3, kLargest_m = 10, kLightest_kg = 1e-3, kHeaviest_kg = 1e3, kMaxFriction = 5;
constexpr unsigned kTicksOneWay = 10;

// Each draw is a separate statement: compilers evaluate the arguments of a call in different orders, and a seed must
// give the same world everywhere.

// About `size` long; every third box is a sliver, up to 1:1000.
Shape random_shape(Draw& random, double size) {
  switch (random.below(3)) {
    case 0:
      return Shape::sphere(0.5 * size);
    case 1: {
      const double half_length = random.uniform(0.05, 0.4) * size;
      const double radius = std::max(random.uniform(0.05, 0.3) * size, 0.5 * kSmallest_m);
      return Shape::capsule(radius, half_length);
    }
    default:
      break;
  }
  Vec3d half{0.5 * size, 0.5 * size * random.uniform(0.2, 1), 0.5 * size * random.uniform(0.2, 1)};
  if (random.chance(0.33)) half[static_cast<int>(random.below(3))] *= random.logarithmic(1e-3, 0.1);
  for (int k = 0; k < 3; ++k) half[k] = std::max(half[k], 0.5 * kSmallest_m);
  return Shape::box(half);
}

double mechanical_J(const CaseWorld& world) {
  return world.world.kinetic_energy() + world.world.potential_energy(world.settings.gravity);
}

}  // namespace

RandomWorld make_random_world(std::uint64_t seed) {
  Draw random(seed);
  RandomWorld world;
  world.seed = seed;
  world.contact_hertz = random.chance(0.5) ? 250 : 1000;
  const double middle = random.logarithmic(kSmallest_m, kLargest_m), spread = random.chance(0.5) ? 3 : 1000;
  const double mass = random.logarithmic(kLightest_kg, kHeaviest_kg), ratio = random.chance(0.5) ? 10 : 1e6;
  const auto count = 2 + random.below(11);
  const double region =
      middle * std::cbrt(count) * random.uniform(0.3, 1.5);  // smaller or larger than the space that they need
  for (std::uint32_t k = 0; k < count; ++k) {
    const double size = std::clamp(middle * random.logarithmic(1 / spread, spread), kSmallest_m, kLargest_m);
    const double weight = std::clamp(mass * random.logarithmic(1 / ratio, ratio), kLightest_kg, kHeaviest_kg);
    const Posed pose{random.vector(region) + Vec3d{0, 0, region}, quat_from_rotation_vector(random.vector(3))};
    const double friction = random.chance(0.2) ? 0 : random.uniform(0, random.chance(0.5) ? 1 : kMaxFriction);
    auto body = physics::make_dynamic_body(k, random_shape(random, size), weight, friction, pose);
    body.motion.velocity = {random.vector(random.chance(0.5) ? 10 : 0.1), random.vector(random.chance(0.5) ? 50 : 0)};
    if (k > 0 && random.chance(0.1)) body.motion.pose = world.bodies.back().motion.pose;  // coincident
    world.bodies.push_back(body);
  }
  if (random.chance(0.8))
    world.bodies.push_back(physics::make_fixed_body(count, Shape::plane(), random.uniform(0, 1), {}));
  if (random.chance(0.3)) {
    const Posed pose{random.vector(region), quat_from_rotation_vector(random.vector(3))};
    const double friction = random.uniform(0, kMaxFriction);
    world.bodies.push_back(
        physics::make_fixed_body(count + 1, Shape::box({0.5 * region, 0.5 * region, 0.5 * region}), friction, pose));
  }
  world.held = random.chance(0.4);
  if (world.held) {
    world.bodies[0].gravity_scale = 0;
    world.stiffness_N_per_m = random.logarithmic(10, 10'000);
    world.damping_Ns_per_m = random.uniform(0, 20);
    world.device_speed_m_per_s = random.vector(1);
  }
  return world;
}

namespace {

constexpr physics::Capacities kCapacities{.bodies = 32, .fixed_bodies = 8, .pairs = 1024, .contacts = 256};

RandomRun run_once(const RandomWorld& random) {
  CaseWorld world({}, random.contact_hertz, kCapacities);
  double mass = 0, weight_moment = 0;
  unsigned moving = 0;
  for (const Body& body : random.bodies) {
    world.add(body);
    if (body.kind == BodyKind::kDynamic) {
      mass += body.mass;
      ++moving;
    }
  }
  auto& spring = world.world.device_spring();
  if (random.held) {
    spring.enabled = true;
    spring.slot = world.slot(random.bodies[0].id);
    spring.stiffness_N_per_m = random.stiffness_N_per_m;
    spring.damping_Ns_per_m = random.damping_Ns_per_m;
    spring.stiffness_Nm_per_rad = 5;
    spring.damping_Nms_per_rad = 0.02;
    spring.target = random.bodies[0].motion.pose;
  }
  weight_moment = mass * kGravity;
  const double start = mechanical_J(world);
  double given = 0, most_excess = 0;
  for (unsigned tick = 0; tick < random.ticks; ++tick) {
    if (random.held) {
      spring.target_velocity.linear = (tick / kTicksOneWay % 2 == 0 ? 1.0 : -1.0) * random.device_speed_m_per_s;
    }
    world.step();
    if (random.held) {
      given += dot(spring.step_impulse.force, spring.target_velocity.linear);
      spring.target.position += world.settings.dt * spring.target_velocity.linear;
    }
    // Upper bound: each body may be pushed by the next at the push speed, all in the same direction.
    const double fastest = world.settings.max_push_speed * moving;
    const double pushed = 2 * mass * fastest * fastest + weight_moment * fastest * world.settings.dt * (tick + 1);
    most_excess = std::max(most_excess, (mechanical_J(world) - start - std::max(given, 0.0)) / pushed);
  }
  Outcome outcome;
  world.close(outcome);
  outcome.gate("pushed out slowly", most_excess <= 1);
  return {outcome.broken_gates.empty() ? std::string() : outcome.broken_gates.front(), outcome.hash};
}

}  // namespace

RandomRun run_twice(const RandomWorld& world) {
  RandomRun run = run_once(world);
  if (run.broken_gate.empty() && run_once(world).hash != run.hash) run.broken_gate = "same state twice";
  return run;
}

RandomWorld shrink(RandomWorld world, const std::function<bool(const RandomWorld&)>& fails) {
  for (bool shrunk = true; shrunk;) {
    shrunk = false;
    for (std::size_t k = world.bodies.size(); k-- > (world.held ? 1u : 0u);) {
      RandomWorld less = world;
      less.bodies.erase(less.bodies.begin() + static_cast<std::ptrdiff_t>(k));
      if (!less.bodies.empty() && fails(less)) {
        world = std::move(less);
        shrunk = true;
      }
    }
    RandomWorld shorter = world;
    shorter.ticks /= 2;
    if (shorter.ticks > 0 && fails(shorter)) {
      world = std::move(shorter);
      shrunk = true;
    }
    RandomWorld free = world;
    free.held = false;
    if (world.held && fails(free)) {
      world = std::move(free);
      shrunk = true;
    }
  }
  return world;
}

RandomWorld settled(RandomWorld random, double seconds) {
  CaseWorld world({}, random.contact_hertz, kCapacities);
  for (Body& body : random.bodies) {
    body.gravity_scale = body.kind == BodyKind::kDynamic ? 1 : 0;
    world.add(body);
  }
  random.held = false;
  world.run(seconds);
  for (Body& body : random.bodies)
    if (body.kind == BodyKind::kDynamic) body.motion = world.body(body.id).motion;
  return random;
}

namespace {

std::string in_toml(const Vec3d& v) { return fmt::format("[{}, {}, {}]", v.x, v.y, v.z); }

std::string in_toml(const Body& body) {
  std::string text = "[[body]]\n";
  switch (body.shape.kind) {
    case ShapeKind::kSphere:
      text += fmt::format("shape = \"sphere\"\nradius_m = {}\n", body.shape.radius);
      break;
    case ShapeKind::kCapsule:
      text += fmt::format("shape = \"capsule\"\nradius_m = {}\nlength_m = {}\n", body.shape.radius,
                          2 * body.shape.half_length);
      break;
    case ShapeKind::kBox:
      text += fmt::format("shape = \"box\"\nsize_m = {}\n", in_toml(2.0 * body.shape.half_extents));
      break;
    default:
      text += "shape = \"plane\"\n";
      break;
  }
  text += fmt::format("friction = {}\nposition_m = {}\n", body.friction, in_toml(body.motion.pose.position));
  const Quatd& q = body.motion.pose.rotation;
  const double sine = norm(q.vec());
  if (sine > 0)
    text += fmt::format("rotation_vector_rad = {}\n", in_toml((2 * std::atan2(sine, q.w) / sine) * q.vec()));
  if (body.kind == BodyKind::kFixed) return text + (body.shape.kind != ShapeKind::kPlane ? "fixed = true\n" : "");
  return text + fmt::format("mass_kg = {}\nvelocity_m_per_s = {}\nangular_velocity_rad_per_s = {}\n", body.mass,
                            in_toml(body.motion.velocity.linear), in_toml(body.motion.velocity.angular));
}

}  // namespace

std::string to_scene(const RandomWorld& world, const std::string& about, const ScriptedHand& hand, unsigned members) {
  const std::string start = in_toml(hand.path.front().at_m);
  std::string text = fmt::format(
      "{}title = \"Random world {}\"\neffects = [\"gravity\", \"friction\", \"gyroscopic\"]\n"
      "[simulation]\nratio = 8\nmembers = {}\ncontact_hertz_Hz = {}\nsub_steps = 4\n"
      "global_sub_steps_per_tick = 4\n"
      "[device]\nposition_m = {}\n"
      "[coupling]\nstiffness_N_per_m = {}\ndamping_Ns_per_m = {}\n"
      "[proxy]\nshape = \"sphere\"\nradius_m = {}\nmass_kg = {}\nfriction = {}\nposition_m = {}\n",
      about, world.seed, members, world.contact_hertz, start, hand.stiffness_N_per_m, hand.damping_Ns_per_m,
      hand.radius_m, hand.mass_kg, hand.friction, start);
  for (const Body& body : world.bodies) text += in_toml(body);
  text += "[hand]\nrepeat = false\npath = [\n";
  for (const auto& point : hand.path)
    text += fmt::format("  {{time_s = {}, position_m = {}}},\n", point.time_s, in_toml(point.at_m));
  return text + "]\n";
}

std::string to_scene(const RandomWorld& world, const std::string& broken_gate) {
  constexpr unsigned kAll = 64;
  const std::string about = fmt::format(
      "# Random world {}, of which this is left: gate broken: {}.\n# {} ticks, {} by the device, device speed {} "
      "m/s.\n",
      world.seed, broken_gate, world.ticks, world.held ? "the first body held" : "nothing held",
      in_toml(world.device_speed_m_per_s));
  return to_scene(world, about, {}, kAll);
}

std::vector<BrokenWorld> broken_worlds(std::uint64_t first, std::uint64_t worlds) {
  std::vector<BrokenWorld> broken;
  for (std::uint64_t seed = first; seed < first + worlds; ++seed) {
    const RandomWorld world = make_random_world(seed);
    const RandomRun run = run_twice(world);
    if (run.broken_gate.empty()) continue;
    const RandomWorld small =
        shrink(world, [](const RandomWorld& less) { return !run_twice(less).broken_gate.empty(); });
    broken.push_back({seed, run.broken_gate, to_scene(small, run.broken_gate)});
  }
  return broken;
}

}  // namespace tactus::hard_cases
