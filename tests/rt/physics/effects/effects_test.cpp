// Effects against mechanics: damping, drag, scripted bodies, bounces, torques of a contact; and that an effect which is
// not used leaves nothing behind.
#include "rt/physics/effects/effects.h"

#include <catch2/catch.hpp>
#include <optional>
#include <vector>

#include "tests/support/physics_bench.h"

using namespace tactus;
using namespace tactus::physics;
using tactus::test::kGravity;
using tactus::test::kPi;

namespace {

struct EffectBench {
  World world;
  StepSettings settings;
  explicit EffectBench(const EffectSetups& setups, const Vec3d& gravity = {0, 0, -kGravity})
      : world(Capacities{}, {}, setups) {
    settings.gravity = gravity;
  }
  void add_ground(BodyId id, double friction, double slope_rad = 0) {
    const Quatd tilt = quat_from_rotation_vector(Vec3d{0, slope_rad, 0});
    REQUIRE(world.insert(make_fixed_body(id, Shape::plane(), friction, {{}, tilt})));
  }
  void add_sphere(BodyId id, double radius, double mass, double friction, const Vec3d& at, const Twistd& velocity) {
    auto made = make_dynamic_body(id, Shape::sphere(radius), mass, friction, {at, {}});
    made.motion.velocity = velocity;
    REQUIRE(world.insert(made));
  }
  void step() {
    world.begin_step(settings);
    find_pairs_brute_force(world.bounds(), world.dynamic_pairs());
    (void)world.finish_step(settings);
  }
  void run(int steps) {
    for (int i = 0; i < steps; ++i) step();
  }
  BodyMotion& motion(BodyId id) { return world.find(id)->motion; }
};

template <class EffectType>
EffectSetups with(const typename EffectType::Setup& setup) {
  EffectSetups setups;
  std::get<typename EffectType::Setup>(setups) = setup;
  return setups;
}

std::uint64_t hash_after(EffectBench& bench) {
  bench.add_ground(0, 0.5);
  bench.add_sphere(1, 0.1, 1, 0.5, {0, 0, 0.15}, {{1, 0, 0}, {}});
  bench.run(500);
  return bench.world.state_hash();
}

}  // namespace

TEST_CASE("An effect that is not used has no memory, and the bits are those of a world without it") {
  const EffectSetups none;
  EffectBench without(none);
  CHECK(without.world.effects().find<Gravity>() != nullptr);
  CHECK(without.world.effects().find<Damping>() == nullptr);
  CHECK(without.world.effects().find<Joints>() == nullptr);
  CHECK(without.world.effects().find<Restitution>() == nullptr);
  CHECK(without.world.effects().save_size_bound() == 0);
  const std::uint64_t expected = hash_after(without);
  const std::vector<double> hard(2, 0.0);  // there, and all zero
  EffectBench with_zeros(with<Restitution>({hard}));
  CHECK(with_zeros.world.effects().find<Restitution>() != nullptr);
  CHECK(hash_after(with_zeros) == expected);
  const std::vector<double> soft(2, 0.5);
  EffectBench bouncing(with<Restitution>({soft}));
  CHECK(hash_after(bouncing) != expected);
}

TEST_CASE("Without the gravity stage nothing falls, whatever the step's gravity") {
  EffectBench bench(with<Gravity>({false}));
  bench.add_sphere(1, 0.1, 1, 0, {}, {});
  bench.run(100);
  CHECK(bench.motion(1).velocity.linear == Vec3d{});
}

TEST_CASE("Damping follows implicit Euler, (1 + h c)^-n, in translation and rotation") {
  EffectBench bench(with<Damping>({2, 30}), {});
  bench.add_sphere(1, 0.1, 1, 0, {}, {{3, 0, -1}, {0, 5, 0}});
  bench.run(250);
  const double h = bench.settings.dt / bench.settings.sub_steps, n = 1000;
  CHECK(bench.motion(1).velocity.linear.x == Approx(3 * std::pow(1 + 2 * h, -n)).epsilon(1e-10));
  CHECK(bench.motion(1).velocity.linear.z == Approx(-1 * std::pow(1 + 2 * h, -n)).epsilon(1e-10));
  CHECK(bench.motion(1).velocity.angular.y == Approx(5 * std::pow(1 + 30 * h, -n)).epsilon(1e-10));
}

TEST_CASE("Drag slows by 1 / v = 1 / v0 + k t exactly, towards the flow, and a fall ends at sqrt(g / k)") {
  const std::vector<double> k{0, 0.7};
  SECTION("decay through a flow") {
    EffectBench bench(with<Drag>({k, {1, 0, 0}}), {});
    bench.add_sphere(1, 0.1, 1, 0, {}, {{6, 0, 0}, {}});
    bench.add_sphere(2, 0.1, 1, 0, {0, 5, 0}, {{6, 0, 0}, {}});  // beyond the list: no drag
    bench.run(800);
    CHECK(bench.motion(1).velocity.linear.x == Approx(1 + 1 / (1 / 5.0 + 0.7 * 0.8)).epsilon(1e-10));
    CHECK(bench.motion(2).velocity.linear.x == 6);
  }
  SECTION("terminal velocity") {
    EffectBench bench(with<Drag>({k, {}}));
    bench.add_sphere(1, 0.1, 1, 0, {}, {});
    bench.run(8000);
    CHECK(bench.motion(1).velocity.linear.z == Approx(-std::sqrt(kGravity / 0.7)).epsilon(1e-3));
  }
}

TEST_CASE("A kinematic body moves as prescribed under what stands on it, and carries it along") {
  const std::vector<KinematicScript> scripts{{1, 0, 0, false}};
  EffectBench bench(with<ScriptedMotion>({scripts, {}}));
  auto platform = make_dynamic_body(1, Shape::box({0.5, 0.5, 0.05}), 1e-3, 0.8, {{0, 0, -0.05}, {}});
  platform.motion.velocity.linear = {0.25, 0, 0};
  REQUIRE(bench.world.insert(platform));
  REQUIRE(bench.world.insert(make_dynamic_body(2, Shape::box({0.05, 0.05, 0.05}), 100, 0.8, {{0, 0, 0.05}, {}})));
  bench.run(1000);
  // A gram under 100 kg, and it moves as if alone.
  CHECK(bench.motion(1).pose.position.x == Approx(0.25).epsilon(1e-12));
  CHECK(bench.motion(1).pose.position.z == -0.05);
  CHECK(bench.motion(2).velocity.linear.x == Approx(0.25).epsilon(1e-6));
  // Slips until mu g t = v, so it is v^2 / (2 mu g) behind.
  CHECK(bench.motion(2).pose.position.x == Approx(0.25 - 0.25 * 0.25 / (2 * 0.8 * kGravity)).epsilon(1e-2));
}

TEST_CASE("A path is a smooth step between its way points, repeats, and is saved where it is") {
  const std::vector<PathKey> keys{{0, {0, 0, 1}, {}}, {1, {2, 0, 1}, {0, 0, 8}}, {2, {0, 0, 1}, {}}};
  const std::vector<KinematicScript> scripts{{1, 0, 3, true}};
  const auto setups = with<ScriptedMotion>({scripts, keys});
  EffectBench bench(setups), other(setups);
  bench.add_sphere(1, 0.1, 1, 0, {0, 0, 1}, {});
  bench.run(250);
  const double u = 0.25, s = u * u * u * (10 - 15 * u + 6 * u * u);
  CHECK(bench.motion(1).pose.position.x == Approx(2 * s).epsilon(1e-9));
  const Vec3d x_axis = rotate(bench.motion(1).pose.rotation, Vec3d{1, 0, 0});
  CHECK(x_axis.x == Approx(std::cos(8 * s)).margin(1e-9));
  CHECK(x_axis.y == Approx(std::sin(8 * s)).margin(1e-9));
  CHECK(bench.motion(1).velocity.linear.x == Approx(2 * 30 * u * u * (1 - u) * (1 - u)).epsilon(1e-3));
  std::vector<std::byte> bytes(bench.world.save_size_bound());
  ByteWriter out(bytes);
  bench.world.save(out);
  REQUIRE(out.ok());
  ByteReader in(std::span<const std::byte>(bytes).first(out.size()));
  REQUIRE(other.world.restore(in));
  bench.run(2000);
  other.run(2000);
  CHECK(bench.motion(1).pose.position.x == Approx(2 * s).epsilon(1e-9));  // one period later
  CHECK(bench.world.state_hash() == other.world.state_hash());
}

TEST_CASE("Spheres head-on: with e = 1 they exchange their velocities, with e = 0.5 they part at half") {
  for (const double e : {1.0, 0.5, 0.0}) {
    const std::vector<double> by_id{e, e};
    EffectBench bench(with<Restitution>({by_id}), {});
    bench.add_sphere(0, 0.1, 2, 0.5, {-0.3, 0, 0}, {{1, 0, 0}, {}});
    bench.add_sphere(1, 0.1, 1, 0.5, {0.3, 0, 0}, {{-0.5, 0, 0}, {}});
    bench.run(600);
    const double v = (2 * 1 + 1 * -0.5) / 3;  // of the common centre
    const double apart = e * 1.5;
    CHECK(bench.motion(0).velocity.linear.x == Approx(v - apart / 3).epsilon(1e-6));
    CHECK(bench.motion(1).velocity.linear.x == Approx(v + 2 * apart / 3).epsilon(1e-6));
  }
}

TEST_CASE("A ball with e = 0.8 comes back to e^2n of its height, five times") {
  const double e = 0.8, radius = 0.05, height = 0.5;
  const std::vector<double> by_id{0, e};
  EffectBench bench(with<Restitution>({by_id}));
  bench.add_ground(0, 0.5);
  bench.add_sphere(1, radius, 0.2, 0.5, {0, 0, radius + height}, {});
  double top = 0, expected = height;
  int bounces = 0;
  bool rising = false;
  for (int i = 0; bounces < 5 && i < 5000; ++i) {
    bench.step();
    const double z = bench.motion(1).pose.position.z - radius, v = bench.motion(1).velocity.linear.z;
    if (v > 0) {
      rising = true;
      top = std::max(top, z);
    }
    if (rising && v <= 0) {
      rising = false;
      ++bounces;
      expected *= e * e;
      CHECK(top == Approx(expected).epsilon(0.02));
      top = 0;
    }
  }
  CHECK(bounces == 5);
}

TEST_CASE("A spinning sphere on a disk of contact stops after I w / (2/3 mu m g R)") {
  const double mass = 0.5, radius = 0.1, patch = 0.02, mu = 0.4, spin = 10;
  const std::vector<ContactPatch> by_id{{}, {patch, 0}};
  EffectBench bench(with<ContactTorque>({by_id}));
  bench.add_ground(0, mu);
  bench.add_sphere(1, radius, mass, mu, {0, 0, radius}, {});
  bench.run(200);  // settled: N = m g
  bench.motion(1).velocity.angular = {0, 0, spin};
  const double inertia = 0.4 * mass * radius * radius, torque = 2.0 / 3 * mu * mass * kGravity * patch;
  const double stop_s = inertia * spin / torque;
  bench.run(static_cast<int>(0.5 * stop_s / bench.settings.dt));
  CHECK(bench.motion(1).velocity.angular.z == Approx(0.5 * spin).epsilon(0.01));
  bench.run(static_cast<int>(0.52 * stop_s / bench.settings.dt));
  CHECK(std::abs(bench.motion(1).velocity.angular.z) < 1e-9);
}

TEST_CASE("Rolling: 5/7 g sin on an incline without the effect, 5/7 g d / r against it on the level, and it rests") {
  const double mass = 0.5, radius = 0.1, d = 0.002, slope = 0.1;
  SECTION("free rolling down") {
    EffectBench bench(EffectSetups{});
    bench.add_ground(0, 0.8, slope);
    bench.add_sphere(1, radius, mass, 0.8, {radius * std::sin(slope), 0, radius * std::cos(slope)}, {});
    bench.run(1000);
    CHECK(norm(bench.motion(1).velocity.linear) == Approx(5.0 / 7 * kGravity * std::sin(slope)).epsilon(5e-3));
  }
  SECTION("slows down on the level") {
    const std::vector<ContactPatch> by_id{{}, {0, d}};
    EffectBench bench(with<ContactTorque>({by_id}));
    bench.add_ground(0, 0.8);
    bench.add_sphere(1, radius, mass, 0.8, {0, 0, radius}, {{1, 0, 0}, {0, 1 / radius, 0}});
    bench.run(1000);
    CHECK(bench.motion(1).velocity.linear.x == Approx(1 - 5.0 / 7 * kGravity * d / radius).epsilon(5e-3));
  }
  SECTION("rests where d / r is more than the slope") {
    const std::vector<ContactPatch> by_id{{}, {0, 1.1 * radius * std::tan(slope)}};
    EffectBench bench(with<ContactTorque>({by_id}));
    bench.add_ground(0, 0.8, slope);
    bench.add_sphere(1, radius, mass, 0.8, {radius * std::sin(slope), 0, radius * std::cos(slope)}, {});
    bench.run(500);
    const Vec3d at = bench.motion(1).pose.position;
    bench.run(1000);
    CHECK(norm(bench.motion(1).pose.position - at) < 1e-5);
  }
}

TEST_CASE("A cylinder on a line of two points is slowed by 2/3 g d / r, and what lies on a face is not touched") {
  const double radius = 0.1, d = 0.002;
  const std::vector<ContactPatch> by_id{{}, {0, d}, {0, d}};
  const auto rolled = [&](bool resisted) {
    EffectBench bench(resisted ? with<ContactTorque>({by_id}) : EffectSetups{});
    bench.add_ground(0, 0.8);
    const Quatd lying = quat_from_rotation_vector(Vec3d{0.5 * kPi, 0, 0});
    auto drum = make_dynamic_body(1, Shape::cylinder(radius, 0.1), 0.5, 0.8, {{0, 0, radius}, lying});
    drum.motion.velocity = {{1, 0, 0}, {0, 1 / radius, 0}};
    REQUIRE(bench.world.insert(drum));
    auto box = make_dynamic_body(2, Shape::box({0.05, 0.05, 0.05}), 0.5, 0.2, {{0, 1, 0.05}, {}});
    box.motion.velocity = {{2, 0, 0}, {0, 0, 3}};
    REQUIRE(bench.world.insert(box));
    bench.run(1000);
    return std::pair(bench.motion(1), bench.motion(2));
  };
  const auto free = rolled(false), slowed = rolled(true);
  CHECK(free.first.velocity.linear.x == Approx(1).epsilon(5e-3));
  // I = m r^2 / 2: (3/2) m r a = -m g d.
  CHECK(slowed.first.velocity.linear.x == Approx(1 - 2.0 / 3 * kGravity * d / radius).epsilon(5e-3));
  CHECK(slowed.second == free.second);
}
