// Corrections of members at a synchronisation, and what the global world needs to know for them.
#include "rt/haptics/coupling/border_correction.h"

#include <limits>

#include "tests/rt/haptics/coupling/sub_world_bench.h"
#include "tests/support/random.h"

using namespace tactus;
using namespace tactus::haptics;
using namespace tactus::test::sub_world_bench;

namespace {

SubWorldConfig ghost_config() {
  SubWorldConfig config = make_config();
  config.border_mode = physics::BorderMode::kGhost;
  return config;
}

// Balls 1 and 2, far apart, after a cycle.
Bench bench_of_balls(std::uint32_t ticks = 5) {
  Bench bench(ghost_config());
  bench.next_with({ball(1, {}, {{0.1, 0, 0}, {0, 0, 1}}), ball(2, {1, 0, 0})});
  bench.synchronise();
  bench.step(ticks);
  bench.next({1, 2});
  return bench;
}

const MotionCorrection kCorrection{.id = 1,
                                   .displacement_m = {1e-3, -2e-3, 3e-3},
                                   .rotation = quat_from_rotation_vector(Vec3d{0.1, 0.2, -0.1}),
                                   .velocity = {{0.1, 0.2, 0.3}, {-1, 2, 3}}};

BodyMotion random_motion(test::Random& random) {
  return {{random.vector(1), quat_from_rotation_vector(random.vector(3))}, {random.vector(2), random.vector(5)}};
}

double off_by(const BodyMotion& a, const BodyMotion& b) {
  return std::max({norm(a.pose.position - b.pose.position),
                   norm(small_rotation_vector(a.pose.rotation * conjugate(b.pose.rotation))),
                   norm(a.velocity.linear - b.velocity.linear), norm(a.velocity.angular - b.velocity.angular)});
}

}  // namespace

TEST_CASE("A correction takes the predicted motion to the global one, and any other by as much") {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    test::Random random(seed);
    const BodyMotion predicted = random_motion(random), global = random_motion(random);
    const MotionCorrection correction = correction_between(3, predicted, global);
    CHECK(correction.id == 3);
    CHECK(off_by(corrected(predicted, correction), global) < 1e-12);
    const BodyMotion other = random_motion(random), after = corrected(other, correction);
    check_close(after.pose.position - other.pose.position, global.pose.position - predicted.pose.position, 1e-12);
    check_close(after.velocity.angular - other.velocity.angular, global.velocity.angular - predicted.velocity.angular,
                1e-12);
  }
}

TEST_CASE("A synchronisation corrects a member before it reports it, on time or late") {
  const std::uint32_t ticks = GENERATE(5u, 7u);
  Bench bench = bench_of_balls(ticks);
  const BodyMotion before = bench.motion(1), other = bench.motion(2);
  REQUIRE(bench.snapshot->corrections.try_push(kCorrection));
  bench.synchronise();
  const BodyMotion after = bench.motion(1);
  CHECK(off_by(after, corrected(before, kCorrection)) < 1e-15);
  CHECK(off_by(before, after) > 0.1);
  CHECK(bench.motion(2) == other);
  REQUIRE(bench.report->members.size() == 2);
  CHECK(bench.report->members[0].motion == after);
  CHECK(bench.report->members[1].motion == other);
  const auto& body = bench.sub_world.world().bodies()[0];
  physics::Body was = body;
  was.motion = before;
  CHECK(bench.sub_world.corrected_J() == Approx(kinetic_energy(body) - kinetic_energy(was)).epsilon(1e-12));
  bench.step(5);
  CHECK(bench.motion(1).pose.position.x ==
        Approx(after.pose.position.x + after.velocity.linear.x * 5 * kTick_s).epsilon(1e-9));
}

TEST_CASE("A sub-world goes on from the motion that another one reports, where it is finite") {
  Bench bench = bench_of_balls();
  const BodyMotion other = bench.motion(2);
  SubWorldReport& reported = *bench.report;
  reported.members.clear();
  reported.effects.clear();
  BodyMotion broken = other;
  broken.velocity.linear.x = std::numeric_limits<double>::quiet_NaN();
  const BodyMotion moved = corrected(bench.motion(1), kCorrection);
  REQUIRE(reported.members.try_push({.id = 1, .motion = moved}));
  REQUIRE(reported.members.try_push({.id = 2, .motion = broken}));
  REQUIRE(reported.members.try_push({.id = 3, .motion = moved}));  // no member
  bench.sub_world.continue_from(reported);
  CHECK(bench.motion(1) == moved);
  CHECK(bench.motion(2) == other);
}

TEST_CASE("A member that leaves is corrected before it is reported") {
  Bench bench = bench_of_balls();
  const BodyMotion before = bench.motion(1);
  bench.next({2});
  REQUIRE(bench.snapshot->corrections.try_push(kCorrection));
  bench.synchronise();
  CHECK_FALSE(bench.is_member(1));
  CHECK(off_by(bench.report->members[0].motion, corrected(before, kCorrection)) < 1e-15);
}

TEST_CASE("A correction of the proxy moves it against the device's spring, whose work is booked") {
  Bench bench(ghost_config());
  bench.next_with({ball(kProxy, {})});
  bench.synchronise();
  bench.step(5, target_at({1e-3, 0, 0}));
  bench.next({kProxy});
  const MotionCorrection back{.id = kProxy, .displacement_m = {-1e-4, 0, 0}, .rotation = {}, .velocity = {}};
  REQUIRE(bench.snapshot->corrections.try_push(back));
  bench.synchronise();
  const double force_N = bench.report->mean_device_wrench.force.x;
  REQUIRE(force_N > 0.1);
  CHECK(bench.sub_world.corrected_J() == Approx(force_N * 1e-4).epsilon(1e-12));
  CHECK(bench.sub_world.proxy() == bench.motion(kProxy));
}

TEST_CASE("A snapshot after a reset has no corrections") {
  Bench bench = bench_of_balls();
  bench.next_with({ball(1, {}), ball(2, {1, 0, 0})});
  bench.snapshot->epoch = 1;
  REQUIRE(bench.snapshot->corrections.try_push(kCorrection));
  bench.synchronise();
  CHECK(bench.motion(1) == ball(1, {}).motion);
}

TEST_CASE("Contacts of members begin a cycle with the global world's impulses") {
  SubWorldConfig config = ghost_config();
  config.step.gravity = {0, 0, -9.81};
  Bench bench(config, {ground()});
  bench.next_with({cube(1, 0.05), cube(2, 0.15)});
  bench.synchronise();
  bench.step(200);
  bench.next({1, 2});
  const double sub_step_s = kTick_s / 4;
  const auto contacts = bench.sub_world.world().contacts();
  const std::vector<physics::Contact> before(contacts.begin(), contacts.end());
  REQUIRE(before.size() == 2);
  const Vec3d added{0.3, -0.2, 0};  // N
  for (const auto& contact : before) {
    physics::WarmStart given = physics::World::warm_start_of(contact, sub_step_s);
    for (std::uint32_t i = 0; i < given.count; ++i) {
      given.normal_force[i] *= 2;
      given.friction_force[i] += added;
    }
    REQUIRE(bench.snapshot->warm_starts.try_push(given));
  }
  bench.synchronise();
  for (std::size_t c = 0; c < 2; ++c) {
    const physics::Contact& now = bench.sub_world.world().contacts()[c];
    REQUIRE(now.count == 4);
    const auto [t1, t2] = tangents_of(now.normal);
    for (std::uint32_t i = 0; i < now.count; ++i) {
      const auto &point = now.points[i], &was = before[c].points[i];
      CHECK(point.normal_impulse == Approx(2 * was.normal_impulse));
      CHECK(point.tangent_impulse[0] == Approx(was.tangent_impulse[0] + sub_step_s * dot(added, t1)));
      CHECK(point.tangent_impulse[1] == Approx(was.tangent_impulse[1] + sub_step_s * dot(added, t2)));
    }
  }
}
