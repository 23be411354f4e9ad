#include <catch2/catch.hpp>

#include "tests/support/physics_bench.h"

using namespace tactus;
using namespace tactus::physics;
using tactus::test::cube_face_mass;
using tactus::test::kGravity;
using tactus::test::PhysicsBench;
using tactus::test::Random;

namespace {

// A cube at rest on a slope, uphill of the origin.
void add_cube_on_slope(PhysicsBench& bench, double slope, double friction) {
  const double half = 0.05;
  bench.add_ground(0, friction, slope);
  const Quatd tilt = quat_from_rotation_vector(Vec3d{0, slope, 0});
  bench.add_box(1, {half, half, half}, 0.4, friction, {rotate(tilt, {0, 0, half}), tilt});
}

Vec3d downhill(double slope) { return {std::cos(slope), 0, -std::sin(slope)}; }

// A cloud of bodies that fly into each other: nothing else acts on them.
void add_cloud(PhysicsBench& bench, std::uint64_t seed) {
  bench.settings.gravity = {};
  Random random(seed);
  for (BodyId id = 0; id < 27; ++id) {
    const Vec3d cell{0.13 * (id % 3) - 0.13, 0.13 * (id / 3 % 3) - 0.13, 0.13 * (id / 9) - 0.13};
    const Vec3d velocity = -4.0 * cell + random.vector(0.2);
    if (id % 2 == 0) {
      bench.add_sphere(id, random(0.03, 0.05), random(0.1, 1), 0.4, cell, velocity);
      bench.velocity(id).angular = random.vector(5);
    } else {
      bench.add_box(id, {random(0.02, 0.035), 0.03, random(0.02, 0.035)}, random(0.1, 1), 0.4,
                    {cell, quat_from_rotation_vector(random.vector(1))}, {velocity, random.vector(5)});
    }
  }
}

}  // namespace

TEST_CASE("A cube on a slope steeper than its friction slides with g (sin - mu cos)") {
  const double slope = 0.5, friction = 0.3;
  PhysicsBench bench;
  add_cube_on_slope(bench, slope, friction);
  bench.run(100);
  const double v0 = dot(bench.velocity(1).linear, downhill(slope));
  bench.run(300);
  const double a = (dot(bench.velocity(1).linear, downhill(slope)) - v0) / 0.3;
  CHECK(a == Approx(kGravity * (std::sin(slope) - friction * std::cos(slope))).epsilon(0.01));
}

// Tables side by side, every second one lower by 20 um. (If every second one is higher by 20 um, some cubes stumble:
// the box may overlap the rim by less sideways than from above.)
TEST_CASE("A cube slides over the joints of tables as over one") {
  const double slope = 0.5, friction = 0.3;
  for (const double step : {0.0, -2e-5}) {
    for (const double yaw : {0.0, 0.35, 0.7}) {
      PhysicsBench bench;
      const Quatd tilt = quat_from_rotation_vector(Vec3d{0, slope, 0});
      for (int i = 0; i < 12; ++i)
        bench.world.insert(make_fixed_body(static_cast<BodyId>(2 + i), Shape::box({0.1, 1, 0.1}), friction,
                                           {rotate(tilt, {0.2 * i, 0, -0.1 + (i % 2 == 1 ? step : 0.0)}), tilt}));
      bench.add_box(1, {0.05, 0.05, 0.05}, 0.4, friction,
                    {rotate(tilt, {0, 0, 0.05}), tilt * quat_from_rotation_vector(Vec3d{0, 0, yaw})});
      bench.run(1000);
      const double a = kGravity * (std::sin(slope) - friction * std::cos(slope));
      INFO("step " << step << " m, yaw " << yaw);
      const Vec3d way = bench.position(1) - rotate(tilt, {0, 0, 0.05});
      CHECK(dot(way, downhill(slope)) == Approx(0.5 * a).epsilon(0.01));
    }
  }
}

TEST_CASE("Without the friction effect a cube slides with g sin") {
  const double slope = 0.3;
  PhysicsBench bench;
  bench.settings.friction = false;
  add_cube_on_slope(bench, slope, 0.9);
  bench.run(100);
  const double v0 = dot(bench.velocity(1).linear, downhill(slope));
  bench.run(300);
  CHECK((dot(bench.velocity(1).linear, downhill(slope)) - v0) / 0.3 ==
        Approx(kGravity * std::sin(slope)).epsilon(0.001));
}

TEST_CASE("A cube on a slope flatter than its friction sticks") {
  const double slope = 0.5;
  PhysicsBench bench;
  add_cube_on_slope(bench, slope, 1.02 * std::tan(slope));
  bench.run(1000);
  const Vec3d before = bench.position(1);
  bench.run(1000);
  CHECK(norm(bench.position(1) - before) < 10e-6);  // in 1 s
}

TEST_CASE("A sphere rolls down a slope with 5/7 g sin") {
  const double slope = 0.3, radius = 0.05;
  PhysicsBench bench;
  bench.add_ground(0, 0.8, slope);
  bench.add_sphere(1, radius, 0.3, 0.8, rotate(quat_from_rotation_vector(Vec3d{0, slope, 0}), {0, 0, radius}));
  bench.run(200);
  const double v0 = dot(bench.velocity(1).linear, downhill(slope));
  bench.run(500);
  const double v1 = dot(bench.velocity(1).linear, downhill(slope));
  CHECK((v1 - v0) / 0.5 == Approx(5.0 / 7 * kGravity * std::sin(slope)).epsilon(0.005));
  CHECK(bench.velocity(1).angular.y * radius == Approx(v1).epsilon(0.001));  // it rolls
}

TEST_CASE("Each cube of a stack of twenty sinks as deep as its load and its effective mass say", "[slow]") {
  const double half = 0.05, mass = 0.1;
  PhysicsBench bench;
  bench.add_ground(0, 0.5);
  bench.add_stack(1, 20, half, mass, 0.5);
  bench.run_seconds(40);  // it sways at first, ever less: by a third every 3 s
  double below = -half;
  for (BodyId id = 1; id <= 20; ++id) {
    const double overlap = 2 * half - (bench.position(id).z - below);
    const double load = mass * kGravity * (21 - id);
    CHECK(overlap == Approx(bench.overlap_under(load, cube_face_mass(mass, half, id == 1))).epsilon(0.05));
    CHECK(norm(bench.velocity(id).linear) < 1e-6);
    below = bench.position(id).z;
  }
  // The bottom carries all of it.
  double carried = 0;
  for (const Contact& contact : bench.world.contacts())
    for (std::uint32_t i = 0; contact.b_fixed && i < contact.count; ++i)
      carried += contact.points[i].total_normal_impulse / bench.settings.dt;
  CHECK(carried == Approx(20 * mass * kGravity).epsilon(1e-4));
}

TEST_CASE("A hundred kilograms on a hundred grams sink as deep as the formula says") {
  PhysicsBench bench;
  bench.settings.contact_hertz = 1000;
  bench.add_ground(0, 0.5);
  bench.add_sphere(1, 0.05, 0.1, 0.5, {0, 0, 0.05});
  bench.add_sphere(2, 0.05, 100, 0.5, {0, 0, 0.15});
  bench.run_seconds(2);
  // Along the normal spheres do not turn: the effective mass is that of two points.
  const double between = 1 / (1 / 0.1 + 1 / 100.0);
  CHECK(0.05 - bench.position(1).z == Approx(bench.overlap_under(100.1 * kGravity, 0.1)).epsilon(0.02));
  CHECK(0.1 - (bench.position(2).z - bench.position(1).z) ==
        Approx(bench.overlap_under(100 * kGravity, between)).epsilon(0.02));
}

TEST_CASE("Two equal spheres that meet head on go on together: contacts do not bounce") {
  PhysicsBench bench;
  bench.settings.gravity = {};
  bench.add_sphere(1, 0.05, 0.3, 0.0, {0, 0, 0}, {1, 0, 0});
  bench.add_sphere(2, 0.05, 0.3, 0.0, {0.2, 0, 0}, {0, 0, 0});
  bench.run(300);
  CHECK(bench.velocity(1).linear.x == Approx(0.5).epsilon(0.01));
  CHECK(bench.velocity(2).linear.x == Approx(0.5).epsilon(0.01));
}

TEST_CASE("With friction in every sweep a wedge at its locking angle comes back less") {
  // A box on its edge in a groove of two planes at 45 degrees: friction just above 1 holds it when it is let go.
  const auto moved_back = [](unsigned relax_sweeps, FrictionSweeps sweeps) {
    const double half = 0.02, friction = 1.02, force_N = 20;
    PhysicsBench bench;
    bench.settings.gravity = {};
    bench.settings.contact_hertz = 1000;
    bench.settings.relax_sweeps = relax_sweeps;
    bench.settings.friction_sweeps = sweeps;
    for (const int side : {-1, 1})
      bench.world.insert(make_fixed_body(static_cast<BodyId>(side + 1), Shape::plane(), friction,
                                         {{}, quat_from_rotation_vector(Vec3d{0, side * tactus::test::kPi / 4, 0})}));
    bench.add_box(1, {half, half, half}, 0.2, friction,
                  {{0, 0, half * std::sqrt(2.0)}, quat_from_rotation_vector(Vec3d{0, tactus::test::kPi / 4, 0})});
    const int ramp = 500;
    for (int k = 1; k <= ramp; ++k) {
      bench.world.apply_wrench(bench.slot(1), {{0, 0, -force_N * k / ramp}, {}});
      bench.step();
    }
    const double pressed_m = bench.position(1).z;
    for (int k = ramp; k >= 0; --k) {
      bench.world.apply_wrench(bench.slot(1), {{0, 0, -force_N * k / ramp}, {}});
      bench.step();
    }
    bench.run_seconds(0.5);
    return bench.position(1).z - pressed_m;
  };
  const double relax = moved_back(1, FrictionSweeps::kRelax), every = moved_back(1, FrictionSweeps::kEvery);
  INFO(relax << " " << every);
  CHECK(every < 0.5 * relax);
  CHECK(moved_back(2, FrictionSweeps::kEvery) < moved_back(2, FrictionSweeps::kRelax));
  CHECK(moved_back(1, FrictionSweeps::kAuto) == relax);
  CHECK(moved_back(2, FrictionSweeps::kAuto) == moved_back(2, FrictionSweeps::kEvery));
}

TEST_CASE("Bodies that only meet each other keep their momentum and never gain energy") {
  for (const unsigned relax_sweeps : {1u, 2u})
    for (const std::uint64_t seed : {1u, 2u, 3u, 4u, 5u, 6u}) {
      PhysicsBench bench;
      bench.settings.relax_sweeps = relax_sweeps;
      add_cloud(bench, seed);
      const Wrenchd start = bench.world.momentum();
      const double start_energy = bench.world.kinetic_energy();
      // One relax sweep may leave a trace of what contacts pushed against each other; a second one takes most of it
      // away.
      const double trace = relax_sweeps == 1 ? 1e-3 : 1e-5;
      double energy = start_energy, size = 0, allowed = 0;
      for (const Body& body : bench.world.bodies()) size += body.mass * norm(body.motion.velocity.linear);
      std::uint32_t touched = 0;
      for (int k = 0; k < 400; ++k) {
        bench.step();
        touched = std::max(touched, bench.report.points);
        REQUIRE(bench.world.kinetic_energy() <= energy + trace * start_energy);
        energy = bench.world.kinetic_energy();
        // Lever arms and inertia are those of the step's start: moments are off by what moves within the step.
        for (const Contact& contact : bench.world.contacts())
          for (std::uint32_t i = 0; i < contact.count; ++i) {
            const Twistd &a = bench.world.bodies()[contact.slot_a].motion.velocity,
                         &b = bench.world.bodies()[contact.slot_b].motion.velocity;
            allowed += (contact.points[i].total_normal_impulse + norm(contact.points[i].total_friction)) *
                       bench.settings.dt *
                       (norm(a.linear) + norm(b.linear) + 0.1 * (norm(a.angular) + norm(b.angular)));
          }
      }
      CHECK(touched > 10);
      CHECK(energy < 0.5 * start_energy);
      CHECK(norm(bench.world.momentum().force - start.force) < 1e-9 * size);
      CHECK(norm(bench.world.momentum().torque - start.torque) < allowed);
      CHECK(allowed < 0.01 * size);
    }
}

TEST_CASE("Friction stays within the cone at every point") {
  PhysicsBench bench;
  add_cloud(bench, 7);
  std::uint32_t sliding = 0;
  for (int k = 0; k < 300; ++k) {
    bench.step();
    for (const Contact& contact : bench.world.contacts())
      for (std::uint32_t i = 0; i < contact.count; ++i) {
        const ContactPoint& p = contact.points[i];
        const double bound = contact.friction * p.total_normal_impulse, rubbed = norm(p.total_friction);
        REQUIRE(p.total_normal_impulse >= 0);
        REQUIRE(rubbed <= bound * (1 + 1e-9) + 1e-18);
        REQUIRE(std::abs(dot(p.total_friction, contact.normal)) <= 1e-12 * (1 + rubbed));
        if (bound > 0 && rubbed > 0.999 * bound) ++sliding;
      }
  }
  CHECK(sliding > 0);
}

TEST_CASE("Bodies that start inside each other part no faster than the push speed") {
  PhysicsBench bench;
  bench.settings.gravity = {};
  bench.add_sphere(1, 0.05, 0.3, 0.5, {0, 0, 0});
  bench.add_sphere(2, 0.05, 0.3, 0.5, {0.09, 0, 0});  // 10 mm deep
  double fastest = 0, apart = 0.09;
  for (int k = 0; k < 500; ++k) {
    bench.step();
    const double now = bench.position(2).x - bench.position(1).x;
    fastest = std::max(fastest, (now - apart) / bench.settings.dt);
    apart = now;
  }
  CHECK(fastest <= bench.settings.max_push_speed * (1 + 1e-9));
  CHECK(fastest > 0.5 * bench.settings.max_push_speed);
  CHECK(apart == Approx(0.1).margin(2e-5));
  CHECK(bench.world.kinetic_energy() <= 0.5 * 0.6 * bench.settings.max_push_speed * bench.settings.max_push_speed);
}

TEST_CASE("A sphere at 10 m/s is stopped by the ground and does not pass it") {
  PhysicsBench bench;
  bench.add_ground(0, 0.5);
  bench.add_sphere(1, 0.01, 0.1, 0.5, {0, 0, 0.1034}, {0, 0, -10});
  for (int k = 0; k < 100; ++k) {
    bench.step();
    REQUIRE(bench.position(1).z > 0.01 - 0.5e-3);
    REQUIRE(bench.velocity(1).linear.z < 0.01);
  }
  CHECK(std::abs(bench.velocity(1).linear.z) < 0.01);
}

TEST_CASE("A load that rests stays where it is when the number of sub-steps changes") {
  PhysicsBench bench;
  bench.add_ground(0, 0.5);
  bench.add_stack(1, 5, 0.05, 0.2, 0.5);
  bench.run_seconds(5);
  const double before = bench.position(5).z;
  for (const unsigned sub_steps : {8u, 2u, 4u, 16u, 1u, 4u}) {
    bench.settings.sub_steps = sub_steps;
    for (int k = 0; k < 20; ++k) {
      bench.step();
      REQUIRE(std::abs(bench.position(5).z - before) < 1e-7);
      REQUIRE(std::abs(bench.velocity(5).linear.z) < 1e-4);
    }
  }
}

TEST_CASE("A cut at any sweep leaves every sub-step done and a finite state, and adds no energy", "[slow]") {
  // An impact at full speed: the worst place to stop, because the impulse of the impact is the next warm start.
  const auto make = [](PhysicsBench& bench) {
    bench.add_ground(0, 0.5);
    bench.add_stack(1, 4, 0.05, 0.2, 0.5);
    bench.run(300);
    bench.add_sphere(10, 0.03, 1.0, 0.5, {0.01, 0.0, 0.432}, {0.3, 0, -5});
    bench.add_sphere(11, 0.03, 1.0, 0.5, {2, 0, 1}, {1, 0, 2});  // flies: shows that no sub-step is lost
    bench.run(1);
  };
  std::uint32_t full = 0;
  struct Probe {
    std::uint32_t at, asked, times{0};
  };
  const auto fire_at = [](void* context, std::uint32_t sweep) noexcept {
    auto* probe = static_cast<Probe*>(context);
    probe->asked = sweep;
    ++probe->times;
    return sweep == probe->at;
  };
  {
    PhysicsBench bench;
    make(bench);
    Probe probe{1000, 0};
    bench.cut = {fire_at, &probe};
    bench.step();
    full = probe.asked + 1;
    CHECK(bench.report.cut_sweep == kNeverCut);
    CHECK(full == bench.settings.sub_steps * (1 + bench.settings.relax_sweeps));
  }
  for (std::uint32_t at = 0; at < full; ++at) {
    for (int steps : {1, 2, 3, 4, 6}) {  // before, at and after the impact
      PhysicsBench bench;
      make(bench);
      bench.run(steps - 1);
      const Vec3d x0 = bench.position(11), v0 = bench.velocity(11).linear;
      const double energy = bench.world.kinetic_energy() + bench.world.potential_energy(bench.settings.gravity);
      Probe probe{at, 0};
      bench.cut = {fire_at, &probe};
      bench.step();
      CHECK(bench.report.cut_sweep == at);
      CHECK(probe.asked == at);
      CHECK(probe.times == at + 1);  // never asked again
      CHECK(norm(bench.position(11) - bench.thrown(x0, v0, bench.settings.sub_steps)) < 1e-12);
      for (const Body& body : bench.world.bodies())
        REQUIRE((is_finite(body.motion.pose) && is_finite(body.motion.velocity)));
      // Overlaps are pushed out: the whole step gives that much, and a cut no more than one push speed of every body
      // on top of it.
      PhysicsBench uncut;
      make(uncut);
      uncut.run(steps);
      const double whole = uncut.world.kinetic_energy() + uncut.world.potential_energy(bench.settings.gravity);
      double mass = 0;
      for (const Body& body : bench.world.bodies()) mass += body.mass;
      const double pushed = 0.5 * mass * bench.settings.max_push_speed * bench.settings.max_push_speed;
      const double now = bench.world.kinetic_energy() + bench.world.potential_energy(bench.settings.gravity);
      CHECK(now <= std::max(energy, whole) + pushed);
      bench.cut = {};
      bench.run(500);
      CHECK(bench.world.kinetic_energy() + bench.world.potential_energy(bench.settings.gravity) <=
            std::max(energy, whole) + pushed);
    }
  }
}

TEST_CASE("A resting stack does not move when every step is cut at its first sweep") {
  PhysicsBench bench;
  bench.add_ground(0, 0.5);
  bench.add_stack(1, 3, 0.05, 0.2, 0.5);
  bench.run_seconds(3);
  const double before = bench.position(3).z;
  bench.cut = {[](void*, std::uint32_t) noexcept { return true; }, nullptr};
  bench.run(200);
  CHECK(bench.report.cut_sweep == 0);
  CHECK(bench.position(3).z == Approx(before).margin(1e-6));
  double carried = 0;
  for (const Contact& contact : bench.world.contacts())
    for (std::uint32_t i = 0; contact.b_fixed && i < contact.count; ++i)
      carried += contact.points[i].total_normal_impulse / bench.settings.dt;
  CHECK(carried == Approx(0.6 * kGravity).epsilon(0.01));  // totals count the sub-steps without sweeps too
}
