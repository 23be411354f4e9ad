// What each coupling makes of a tick, and that what is saved of a sub-world is the whole of it.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "rt/base/bytes.h"
#include "rt/base/status.h"
#include "rt/haptics/coupling/sub_world.h"
#include "tests/rt/haptics/coupling/sub_world_bench.h"
#include "tests/support/physics_bench.h"
#include "tests/support/rt_guard.h"

using namespace tactus;
using namespace tactus::haptics;
using namespace tactus::test::sub_world_bench;
using test::kGravity;

TEST_CASE("interpolation: the proxy goes evenly from one global state to the next in a cycle, and waits there") {
  const SubWorldConfig config = make_config(CouplingScheme::kInterpolation);
  Bench bench(config);
  const Posed from{{0.1, 0.2, 0.3}, quat_from_rotation_vector(Vec3d{0.5, 0, 0.1})};
  const Quatd turn = quat_from_rotation_vector(Vec3d{0.03, -0.05, 0.04});
  const Posed to{{0.11, 0.19, 0.32}, turn * from.rotation};
  bench.next({});
  bench.snapshot->proxy = {from, {}};
  bench.synchronise();
  CHECK(bench.sub_world.proxy().pose == from);
  bench.step(config.ratio);
  CHECK(norm(bench.sub_world.proxy().pose.position - from.position) <= 1e-15);
  CHECK(bench.sub_world.proxy().velocity == Twistd{});

  // A quaternion and its negative are the same turn.
  const bool flipped = GENERATE(false, true);
  const Quatd& q = to.rotation;
  bench.snapshot->proxy = {{to.position, flipped ? Quatd{-q.w, -q.x, -q.y, -q.z} : q}, {}};
  bench.synchronise();
  const double cycle_s = config.ratio * kTick_s;
  for (std::uint32_t i = 1; i <= config.ratio; ++i) {
    bench.step();
    const double share = static_cast<double>(i) / config.ratio;
    const auto& proxy = bench.sub_world.proxy();
    check_close(proxy.pose.position, from.position + share * (to.position - from.position), 1e-15);
    const Quatd turned = proxy.pose.rotation * conjugate(from.rotation);
    check_close(small_rotation_vector(turned), share * small_rotation_vector(turn), 1e-5);
    check_close(proxy.velocity.linear, (1 / cycle_s) * (to.position - from.position), 1e-12);
    check_close(proxy.velocity.angular, (1 / cycle_s) * Vec3d{0.03, -0.05, 0.04}, 1e-2);
  }
  for (int i = 0; i < 7; ++i) {
    const auto& proxy = bench.sub_world.proxy();
    check_close(proxy.pose.position, to.position, 1e-15);
    check_close(small_rotation_vector(proxy.pose.rotation * conjugate(to.rotation)), {}, 1e-15);
    bench.step();
    CHECK(proxy.velocity == Twistd{});
    CHECK((bench.last.status & kWorldLate) != 0);
  }
}

TEST_CASE("interpolation: the spring is felt, and where the device is goes up with its mean velocity over the cycle") {
  const SubWorldConfig config = make_config(CouplingScheme::kInterpolation);
  Bench bench(config);
  bench.next_with({ball(kProxy, {})});
  bench.synchronise();
  CHECK_FALSE(bench.report->device.engaged);
  bench.next({kProxy});
  bench.snapshot->proxy.pose.position = {0.01, 0, 0};
  bench.synchronise();
  const Vec3d rotated{0, 0, 0.02}, at{0.02, 0, 0}, velocity{0, 0.1, 0};
  const DeviceTarget target{true, {at, quat_from_rotation_vector(rotated)}, {velocity, {}}};
  for (std::uint32_t i = 1; i <= config.ratio; ++i) {
    bench.step(1, target);
    const Vec3d proxy{0.01 * i / config.ratio, 0, 0}, proxy_velocity{0.01 / (config.ratio * kTick_s), 0, 0};
    const Vec3d force =
        config.gains.stiffness_N_per_m * (at - proxy) + config.gains.damping_Ns_per_m * (velocity - proxy_velocity);
    check_close(bench.last.on_device.force, -force, 1e-9);
    check_close(bench.last.on_device.torque, -config.gains.stiffness_Nm_per_rad * rotated, 1e-5);
  }
  // At the end of the last tick. It did not hold the proxy when the cycle began: its own velocity counts.
  bench.synchronise();
  CHECK(bench.report->device.engaged);
  check_close(bench.report->device.pose.position, at + kTick_s * velocity, 1e-15);
  check_close(small_rotation_vector(bench.report->device.pose.rotation), rotated, 1e-5);
  CHECK(bench.report->device.velocity == target.velocity);
  CHECK(bench.report->members.empty());
  CHECK(bench.report->border.empty());
  CHECK(bench.report->mean_device_wrench == Wrenchd{});
  // From there in one cycle, with a last tick at rest.
  const Vec3d to{0.03, 0.02, 0};
  const Vec3d turned{0, 0.01, 0.02};
  bench.step(config.ratio, {true, {to, quat_from_rotation_vector(turned)}, {}});
  bench.synchronise();
  const double cycle_s = config.ratio * kTick_s;
  check_close(bench.report->device.velocity.linear, (to - at - kTick_s * velocity) * (1 / cycle_s), 1e-12);
  check_close(bench.report->device.velocity.angular, (turned - rotated) * (1 / cycle_s), 3e-2);
  bench.step(2);  // not engaged: the proxy is not held
  bench.synchronise();
  CHECK_FALSE(bench.report->device.engaged);
}

TEST_CASE("static: only the proxy moves, the others keep their bits though pushed, and only the proxy is reported") {
  SubWorldConfig config = make_config(CouplingScheme::kStatic);
  config.step.gravity = {0, 0, -kGravity};
  Bench bench(config, {ground()});
  auto proxy = ball(kProxy, {0, 0, 0.2 + kRadius + 1e-3});
  proxy.gravity_scale = 0;
  auto frozen = cube(1, 0.15);
  frozen.motion.velocity = {{0.1, 0, 0}, {0, 0, 1}};
  bench.next_with({proxy, frozen, cube(2, 1.0)});
  bench.synchronise();
  const auto falling = bench.motion(2);
  for (std::uint32_t i = 0; i < 200; ++i) bench.step(1, target_at({0, 0, 0.2 + kRadius - 2e-3}));
  CHECK(same_bits(bench.motion(1), frozen.motion));
  CHECK(same_bits(bench.motion(2), falling));
  CHECK((bench.last.status & kProxyContact) != 0);
  // It rests on the frozen cube, and the hand carries the spring.
  CHECK(bench.last.on_device.force.z == Approx(config.gains.stiffness_N_per_m * 2e-3).epsilon(0.05));
  CHECK(std::abs(bench.motion(kProxy).pose.position.z - 0.2 - kRadius) < 1e-4);

  const auto held = bench.motion(kProxy);
  auto moved = frozen;
  moved.motion.pose.position.x = 1.0 / 3;
  bench.next_with({proxy, moved, cube(2, 0.9)});
  bench.synchronise();
  REQUIRE(bench.report->members.size() == 1);
  CHECK(bench.report->members[0].id == kProxy);
  CHECK(same_bits(bench.report->members[0].motion, held));
  CHECK(same_bits(bench.motion(kProxy), held));
  CHECK(same_bits(bench.motion(1), moved.motion));
  CHECK(bench.motion(2).pose.position.z == 0.9);
  bench.step(3);
  CHECK(same_bits(bench.motion(1), moved.motion));
}

TEST_CASE("direct: the dynamic bodies given are members, and nothing is ever late") {
  SubWorldConfig config = make_config(CouplingScheme::kDirect);
  config.step.gravity = {0, 0, -kGravity};
  Bench bench(config, {ground()});
  const std::vector<Body> bodies{ground(), ball(3, {0, 0, 1}), ball(kProxy, {1, 0, 1})};
  bench.sub_world.set_members(bodies);
  CHECK(bench.sub_world.members() == 2);
  CHECK_FALSE(bench.sub_world.exchanges());
  CHECK(bench.sub_world.proxy().pose.position == Vec3d{1, 0, 1});
  for (int i = 0; i < 300; ++i) {
    bench.step();
    REQUIRE((bench.last.status & (kWorldLate | kBorderFrozen | kWorldFade)) == 0);
    REQUIRE(bench.last.force_scale == 1);
  }
  // 300 ticks of four sub-steps: x(n) = -g h^2 n (n + 1) / 2.
  const double h = kTick_s / 4;
  CHECK(bench.motion(3).pose.position.z == Approx(1 - kGravity * h * h * 1200 * 1201 / 2).epsilon(1e-12));
}

namespace {

// A stack with a border on top, pressed by the proxy; a synchronisation every eighth tick, so the world is often late.
struct Busy : Bench {
  static SubWorldConfig busy_config() {
    SubWorldConfig config = make_config();
    config.step.gravity = {0, 0, -kGravity};
    return config;
  }
  Busy() : Bench(busy_config(), {ground()}) {}

  void begin() {
    auto proxy = ball(kProxy, {0, 0, 0.3 + kRadius});
    proxy.gravity_scale = 0;
    next_with({proxy, cube(1, 0.05), cube(2, 0.15), cube(3, 0.25)});
    add_border();
    synchronise();
  }
  void add_border() {
    BorderPoint side = support(2, 4, 0.3);
    side.normal = {1, 0, 0};
    side.member_anchor = {-0.05, 0.01, 0.02};
    side.outside_velocity = {0.01, 0.02, 0};
    REQUIRE(snapshot->border.try_push(side));
    REQUIRE(snapshot->border.try_push(support(3, 1, 0.3)));
  }
  void tick(std::uint32_t t) {
    if (t % 8 == 7) {
      next({kProxy, 1, 2, 3});
      add_border();
      synchronise();
    }
    const double swing = 1e-4 * static_cast<double>(t % 13);
    step(1, {true, {{swing, 0, 0.3 + kRadius - 1e-3 - swing}, {}}, {{0.01, 0, 0}, {}}}, 2 + t % 3);
  }
};

}  // namespace

TEST_CASE("a sub-world restored in the middle of a cycle goes on bit by bit") {
  Busy original;
  original.begin();
  for (std::uint32_t t = 0; t < 27; ++t) original.tick(t);
  REQUIRE(original.sub_world.ticks_in_cycle() == 4);
  REQUIRE(original.sub_world.border_contacts() == 2);
  std::vector<std::byte> bytes(original.sub_world.save_size_bound());
  ByteWriter out(bytes);
  original.sub_world.save(out);
  REQUIRE(out.ok());
  bytes.resize(out.size());

  Busy copy;
  ByteReader in(bytes);
  REQUIRE(copy.sub_world.restore(in));
  CHECK(in.remaining() == 0);
  CHECK(copy.sub_world.state_hash() == original.sub_world.state_hash());
  CHECK(copy.sub_world.border_contacts() == 2);
  CHECK(copy.sub_world.border_work_J() == original.sub_world.border_work_J());
  for (std::uint32_t t = 27; t < 90; ++t) {
    original.tick(t);
    copy.tick(t);
    CAPTURE(t);
    REQUIRE(copy.sub_world.state_hash() == original.sub_world.state_hash());
    REQUIRE(same_bits(copy.last.on_device, original.last.on_device));
    REQUIRE(copy.last.status == original.last.status);
    REQUIRE(copy.sub_world.border_work_J() == original.sub_world.border_work_J());
    REQUIRE(copy.report->ticks == (t < 31 ? 0 : original.report->ticks));
    if (t < 31) continue;
    REQUIRE(copy.report->mean_device_wrench == original.report->mean_device_wrench);
    REQUIRE(copy.report->border[0].tangent_impulse == original.report->border[0].tangent_impulse);
  }
}

TEST_CASE("bytes that are cut short are no sub-world") {
  Busy original;
  original.begin();
  for (std::uint32_t t = 0; t < 12; ++t) original.tick(t);
  std::vector<std::byte> bytes(original.sub_world.save_size_bound());
  ByteWriter out(bytes);
  original.sub_world.save(out);
  Busy copy;
  for (std::size_t size = 0; size < out.size(); size += 3) {
    ByteReader in(std::span<const std::byte>(bytes).first(size));
    REQUIRE_FALSE(copy.sub_world.restore(in));
  }
}

TEST_CASE("a synchronisation and a tick neither allocate nor lock") {
  Busy busy;
  busy.begin();
  busy.next({kProxy, 1, 2});
  busy.add_border();
  const test::RtGuard guard;
  busy.synchronise();
  busy.step(3, target_at({0, 0, 0.3}));
  const auto allocations = guard.allocations(), locks = guard.locks();
  CHECK(allocations == 0);
  CHECK(locks == 0);
}
