// A tick with a device that works: arming, force, snapshots in time and late; and properties of every tick.
#include "rt/loop/haptic_loop.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "rt/haptics/coupling_limits.h"
#include "tests/rt/loop/haptic_loop_bench.h"
#include "tests/support/bits.h"
#include "tests/support/physics_bench.h"
#include "tests/support/rt_guard.h"

using namespace tactus;
using namespace tactus::loop;
using namespace tactus::test::haptic_loop_bench;

TEST_CASE("until it is armed the loop commands no force, and the sequence counts") {
  Bench bench;
  for (std::uint64_t t = 0; t < 200; ++t) {
    bench.tool.position.x = 1e-4 * static_cast<double>(t);
    bench.tick();
    CHECK(bench.out.tick == t);
    CHECK(bench.out.command.sequence == t + 1);
    CHECK(bench.out.command.wrench == Wrenchd{});
    CHECK(bench.out.command.wanted == DeviceState::kIdle);
    CHECK(bench.out.command.rearm == 0);
    CHECK((bench.out.status & kNotArmed) != 0);
    CHECK(bench.out.fault == Fault::kNone);
  }
}

TEST_CASE("arming engages where the device is: the target is on the proxy and the force does not step") {
  const Posed proxy{{3, -2, 1}, quat_from_rotation_vector(Vec3d{0.5, 0.2, -0.9})};
  Bench bench(make_config(), anvil(proxy));
  bench.tool = {{0.05, -0.08, 0.02}, quat_from_rotation_vector(Vec3d{0, 0.7, 0.1})};
  bench.run(5);
  bench.tick(kArm);
  CHECK(bench.out.command.wanted == DeviceState::kForce);
  CHECK((bench.out.status & kNotArmed) == 0);
  check_close(bench.out.target.position, proxy.position, 1e-12);
  check_close(small_rotation_vector(bench.out.target.rotation * conjugate(proxy.rotation)), {}, 1e-12);
  CHECK(norm(bench.out.wanted.force) < 1e-8);
  CHECK(norm(bench.out.wanted.torque) < 1e-8);
  bench.run(100);
  CHECK(bench.force_step_max < 1e-8);
  CHECK(bench.out.command.wanted == DeviceState::kForce);
}

TEST_CASE("a device without good samples does not engage until it has one") {
  Bench bench;
  bench.tick(kArm, ReadStatus::kMissing);
  CHECK(bench.out.command.wanted == DeviceState::kIdle);
  CHECK((bench.out.status & kNotArmed) != 0);
  bench.tick();
  CHECK(bench.out.command.wanted == DeviceState::kForce);
}

TEST_CASE("after engaging the force comes in over 0.2 s") {
  Bench bench;
  bench.run(3);
  bench.tick(kArm);
  bench.move({1e-3, 0, 0});
  const auto moved = bench.out.tick - 3;  // ticks since the arming one
  for (std::uint64_t n = moved + 2; n < 260; ++n) {
    bench.tick();
    if (n < 30) continue;  // until the velocity estimate is at rest
    const double share = std::min(1.0, static_cast<double>(n) / 200.0);
    CAPTURE(n);
    check_close(bench.out.command.wrench.force, {-share * kStiffness * 1e-3, 0, 0}, 1e-6);
  }
}

TEST_CASE("disarming ends the force under the slew limit, and has priority over other requests") {
  Bench bench;
  bench.hold({5e-3, 0, 0});
  REQUIRE(bench.force() == Approx(kStiffness * 5e-3).epsilon(1e-6));
  const std::uint32_t bits = GENERATE(kDisarm, kDisarm | kArm, kDisarm | kRearm);
  bench.tick(bits);
  CHECK(bench.out.command.wanted == DeviceState::kIdle);
  CHECK((bench.out.status & kNotArmed) != 0);
  bench.tick();  // 10 N at 5 N a tick
  for (int i = 0; i < 50; ++i) {
    bench.tick();
    CHECK(bench.out.command.wrench == Wrenchd{});
    CHECK(bench.out.command.wanted == DeviceState::kIdle);
  }
  CHECK(bench.force_step_max <= 5.0 + 1e-9);
}

TEST_CASE("a disarmed loop does not damp for energy that the hand got before") {
  LoopConfig config = make_config();
  config.sub_world.gains.damping_Ns_per_m = 0.1;
  config.device.damping_Ns_per_m = 0.05;
  Bench bench(config);
  bench.run(3);
  bench.tick(kArm);
  // A sampled spring without damping gives about 1/2 K v^2 T^2 per tick to the hand that moves it.
  double t_s = 0;
  const auto swing = [&](std::uint32_t bits = 0) {
    t_s += 1e-3;
    bench.tool.position.x = 5e-3 * std::sin(2 * test::kPi * 5 * t_s);
    bench.tick(bits);
  };
  while (t_s < 3 && ((bench.out.status & kPassivityActive) == 0 || t_s < 1)) swing();
  REQUIRE((bench.out.status & kPassivityActive) != 0);
  swing(kDisarm);
  for (int i = 0; i < 10; ++i) swing();
  for (int i = 0; i < 300; ++i) {
    swing();
    REQUIRE(bench.out.command.wrench == Wrenchd{});
    REQUIRE((bench.out.status & kPassivityActive) == 0);
  }
}

TEST_CASE("the work of the coupling on the proxy is the proxy's own energy, where nothing else touches it") {
  LoopConfig config = make_config();
  config.sub_world.step.gravity = {};
  const double mass = 0.2;
  const auto ball = physics::make_dynamic_body(kProxy, Shape::sphere(0.01), mass, 0.5, {});
  Bench bench(config, ball);
  bench.run(3);
  bench.tick(kArm);
  double most_J = 0;
  for (int k = 0; k < 300; ++k) {
    bench.tool.position.x = 0.02 * (1 - std::cos(2 * test::kPi * 3 * 1e-3 * k));
    bench.tick();
    const double kinetic_J = 0.5 * mass * norm_squared(bench.out.proxy.velocity.linear);
    most_J = std::max(most_J, kinetic_J);
    // The work is never less than the kinetic energy: semi-implicit Euler moves a body with the new velocity, a little
    // further than with the mean one.
    REQUIRE(bench.loop.sub_world().proxy_work_J() == Approx(kinetic_J).epsilon(0.05).margin(2e-4));
    REQUIRE(bench.loop.sub_world().proxy_work_J() > kinetic_J - 1e-9);
  }
  CHECK(most_J > 5e-3);
}

TEST_CASE(
    "an overlap is told by its share of the thinner body, in the ticks in which it is a good part of the thinnest") {
  LoopConfig config = make_config();
  config.sub_world.step.gravity = {};
  config.thinnest_m = GENERATE(0.02, 1.0, 0.0);  // of the ball, of another; not asked for
  const auto ground = physics::make_fixed_body(9, Shape::plane(), 0.5, {});
  loop::HapticLoop loop(config, {&ground, 1});
  const auto ball = physics::make_dynamic_body(kProxy, Shape::sphere(0.01), 0.2, 0.5, {{0, 0, 0.006}, {}});
  loop.set_members({&ball, 1});
  TickInput in;
  TickOutput out;
  in.device.sample.state = DeviceState::kIdle;
  loop.tick(in, out);
  CHECK(out.deepest_m == Approx(0.004).epsilon(1e-6));
  CHECK(out.deepest_share == (config.thinnest_m == 0.02 ? Approx(0.2).epsilon(1e-6) : Approx(0)));
}

// The device has the mass, damping and quantum of the loop's configuration; the gains exceed what check_coupling
// allows.
TEST_CASE("at 2 and 2.5 times the accepted gain the passivity controller holds a device that feels its force late") {
  const int late = GENERATE(1, 2);
  const double share = GENERATE(2.0, 2.5, 3.0);
  LoopConfig config = make_config();
  haptics::DeviceProperties& device = config.device;
  device.delay_s = late * config.period_s;
  device.max_force_N = device.continuous_force_N = 1e6;  // nothing but the controller bounds the energy
  device.max_speed_m_per_s = 1e4;
  device.workspace_radius_m = 1e3;
  const auto accepted = haptics::check_coupling({}, device, config.period_s).translation.stiffness_allowed;
  config.sub_world.gains.stiffness_N_per_m = share * accepted;
  Bench bench(config);
  bench.run(3);
  bench.tick(kArm);
  bench.run(250);
  double x = 0, v = 0.1, work_J = 0, most_J = 0;
  int active = 0;
  std::vector<double> sent(static_cast<std::size_t>(late) + 1);
  const double m = device.mass_kg, b = device.damping_Ns_per_m, T = config.period_s, decay = std::exp(-b / m * T);
  for (int k = 0; k < 5000; ++k) {
    bench.tool.position.x = std::round(x / device.position_quantum_m) * device.position_quantum_m;
    bench.tick();
    REQUIRE(bench.out.fault == Fault::kNone);
    sent.insert(sent.begin(), bench.out.command.wrench.force.x);
    sent.pop_back();
    const double end = sent.back() / b, before = x;
    x += end * T + (v - end) * (m / b) * (1 - decay);
    v = end + (v - end) * decay;
    work_J += sent.back() * (x - before);
    most_J = std::max(most_J, work_J);
    REQUIRE(std::abs(x) < 0.1);
    // The loop's energy equals what the device received, up to the commands in transit and one quantum.
    if (k % 500 == 499) CHECK(bench.out.device_energy_J == Approx(-work_J).margin(1e-3));
    if ((bench.out.status & kPassivityActive) != 0) ++active;
  }
  CAPTURE(late, share);
  CHECK(most_J < 0.05);
  if (share > 2.4) CHECK(active > 0);  // at 2 the target that runs ahead of the sample still keeps it stable
}

TEST_CASE("with a turned and scaled placement the wrench is in the device's frame and the power is the same") {
  LoopConfig config = make_config();
  const double s = 3;
  const Quatd turn = quat_from_rotation_vector(Vec3d{0.4, -1.1, 0.7});
  config.placement = {{{0.5, 0.6, 0.7}, turn}, s, true};
  Bench bench(config);
  bench.run(3);
  bench.tick(kArm);
  const Vec3d by{0.3e-3, -0.2e-3, 0.4e-3}, rotated{0.003, 0.004, -0.002};
  const Vec3d target_before = bench.out.target.position;
  bench.move(by);
  bench.tool.rotation = quat_from_rotation_vector(rotated);
  bench.run(300);
  const Vec3d stretch = bench.out.target.position - target_before;
  check_close(stretch, s * rotate(turn, by), 1e-12);
  check_close(bench.out.wanted.force, -(s * s * kStiffness) * by, 1e-6);
  check_close(bench.out.wanted.torque, -kRotationStiffness * rotated, 1e-5);
  check_close(bench.out.command.wrench.force, bench.out.wanted.force, 1e-9);
  // What the hand gives along its path the spring gets along the target's: f_d . x_d = f_w . x_w.
  CHECK(dot(bench.out.wanted.force, by) == Approx(-kStiffness * norm_squared(stretch)).epsilon(1e-6));
}

TEST_CASE("a snapshot is wanted after r ticks, adopted first and its report published before the tick goes on") {
  Bench bench(make_config(CouplingScheme::kSubWorld));
  struct Seen {
    const HapticLoop* loop;
    std::uint64_t cycle{99};
    std::uint32_t members{0}, calls{0};
  } seen{&bench.loop};
  const auto snapshot = std::make_unique<haptics::WorldSnapshot>();
  const auto report = std::make_unique<haptics::SubWorldReport>();
  REQUIRE(snapshot->members.try_push(kProxy));
  REQUIRE(snapshot->joiners.try_push(anvil({{1, 2, 3}, {}})));
  bench.in.sink.report = report.get();
  bench.in.sink.context = &seen;
  bench.in.sink.publish = [](void* context, std::uint64_t cycle) noexcept {
    auto& s = *static_cast<Seen*>(context);
    s.cycle = cycle;
    s.members = s.loop->sub_world().members();
    ++s.calls;
  };
  for (std::uint64_t cycle = 0; cycle < 3; ++cycle) {
    REQUIRE(bench.loop.wants_snapshot());
    CHECK(bench.loop.next_cycle() == cycle);
    snapshot->cycle = cycle;
    bench.in.snapshot = snapshot.get();
    bench.tick(cycle == 0 ? kArm : 0u);
    CHECK(seen.cycle == cycle);
    CHECK(seen.calls == cycle + 1);
    CHECK(seen.members == 1);
    CHECK(report->ticks == (cycle == 0 ? 0 : 5));
    // Engaged in the tick of adoption, on the proxy that came with it.
    if (cycle == 0) CHECK(bench.out.target.position == Vec3d{1, 2, 3});
    bench.in.snapshot = nullptr;
    for (int i = 0; i < 4; ++i) {
      CHECK_FALSE(bench.loop.wants_snapshot());
      bench.tick();
    }
    CHECK(bench.loop.wants_snapshot());
  }
}

TEST_CASE("a lost world fades the force without a fault, and with the next snapshot it ramps in from where it was") {
  Bench bench(make_config(CouplingScheme::kSubWorld));
  const auto snapshot = std::make_unique<haptics::WorldSnapshot>();
  const auto report = std::make_unique<haptics::SubWorldReport>();
  REQUIRE(snapshot->members.try_push(kProxy));
  REQUIRE(snapshot->joiners.try_push(anvil()));
  bench.in.sink.report = report.get();
  const auto synchronise = [&](std::uint32_t bits = 0) {
    bench.in.snapshot = snapshot.get();
    bench.tick(bits);
    bench.in.snapshot = nullptr;
    ++snapshot->cycle;
  };
  // Ticks of a cycle up to the last one at full force: the r-th is late by nothing, the next ones by 1 ms more each.
  const int full = 5 + 100;
  synchronise(kArm);
  bench.move({1e-3, 0, 0});
  for (int i = 0; i < 50; ++i) {
    synchronise();
    bench.run(5);
  }
  synchronise();
  bench.run(full - 1);
  const double whole = kStiffness * 1e-3;
  const double kClose = 1e-5;  // 1e9 kg are not quite at rest
  CHECK(bench.force() == Approx(whole).margin(kClose));

  const int lost = GENERATE(4, 10, 40);  // faded to 0.6, to nothing, and long after
  for (int i = 1; i <= lost; ++i) {
    bench.tick();
    CAPTURE(i);
    CHECK(bench.force() == Approx(whole * std::max(0.0, 1 - 0.1 * i)).margin(kClose));
    CHECK((bench.out.status & kWorldFade) != 0);
    CHECK(bench.out.fault == Fault::kNone);
    CHECK(bench.out.command.wanted == DeviceState::kForce);
  }
  const double left = std::max(0.0, 1 - 0.1 * lost);
  for (int n = 1; n <= 220; ++n) {
    n % 10 == 1 ? synchronise() : static_cast<void>(bench.tick());
    CAPTURE(n);
    CHECK((bench.out.status & kWorldFade) == 0);
    CHECK(bench.force() == Approx(whole * std::min(1.0, left + n / 200.0)).margin(kClose));
  }
}

namespace {

// A ball between blocks on the ground, and a hand that does anything at all.
struct Chaos {
  explicit Chaos(std::uint64_t seed) : random(seed), loop(config(), fixed()) { loop.set_members(members()); }

  static LoopConfig config() {
    LoopConfig c = make_config();
    c.sub_world.step.gravity = {0, 0, -9.81};
    c.placement.motion_scale = 1.5;
    return c;
  }
  static std::vector<Body> fixed() { return {physics::make_fixed_body(9, Shape::plane(), 0.5, {})}; }
  static std::vector<Body> members() {
    auto proxy = physics::make_dynamic_body(kProxy, Shape::sphere(0.02), 0.2, 0.5, {{0, 0, 0.12}, {}});
    proxy.gravity_scale = 0;
    const auto block = Shape::box({0.05, 0.05, 0.05});
    return {proxy, physics::make_dynamic_body(1, block, 1.0, 0.5, {{0, 0, 0.05}, {}}),
            physics::make_dynamic_body(2, block, 1.0, 0.5, {{0.11, 0, 0.05}, {}})};
  }

  bool chance(double p) { return random(0, 1) < p; }
  double garbage() {
    const double kinds[] = {kNaN, std::numeric_limits<double>::infinity(), -1e300, 1e308, 5e-324, random(-10, 10)};
    return kinds[static_cast<int>(random(0, 5.999))];
  }

  // The next input: mostly a walk that can be believed, now and then rubbish in any field.
  const TickInput& next() {
    auto& sample = in.device.sample;
    in.device.status = chance(0.97) ? ReadStatus::kFresh : static_cast<ReadStatus>(static_cast<int>(random(0, 3.999)));
    if (chance(0.98)) {
      ++sample.sequence;
      sample.device_time_ns += 1'000'000;
    }
    if (chance(0.001)) sample.sequence = static_cast<std::uint64_t>(random(0, 1e19));
    tool.position += random.vector(6e-4);
    if (norm(tool.position) > 0.19) tool.position *= 0.99;
    tool.rotation = normalized(quat_from_rotation_vector(random.vector(4e-3)) * tool.rotation);
    sample.device_from_tool = tool;
    if (chance(0.02)) sample.device_from_tool.position[static_cast<int>(random(0, 2.999))] = garbage();
    if (chance(0.02)) sample.device_from_tool.rotation.x = garbage();
    if (chance(0.02)) sample.device_from_tool.rotation.w *= 1.01;
    if (chance(0.02)) tool.position += random.vector(0.05);
    sample.state = chance(0.995) ? last_wanted : static_cast<DeviceState>(static_cast<int>(random(0, 3.999)));
    if (chance(0.05) && sample.state == DeviceState::kBrake) sample.state = DeviceState::kIdle;
    sample.device_fault = chance(0.002) ? static_cast<std::uint32_t>(random(0, 100)) : 0;
    in.operator_bits = chance(0.05) ? static_cast<std::uint32_t>(random(0, 7.999)) : 0;
    if (chance(0.04)) in.operator_bits |= kRearm;
    in.sub_steps = 1 + static_cast<std::uint32_t>(random(0, 3.999));
    return in;
  }
  void tick() {
    loop.tick(next(), out);
    last_wanted = out.command.wanted;
  }

  test::Random random;
  HapticLoop loop;
  TickInput in;
  TickOutput out;
  Posed tool;
  DeviceState last_wanted{DeviceState::kIdle};
};

std::vector<std::byte> saved(const HapticLoop& loop) {
  std::vector<std::byte> bytes(loop.save_size_bound());
  ByteWriter out(bytes);
  loop.save(out);
  REQUIRE(out.ok());
  bytes.resize(out.size());
  return bytes;
}

}  // namespace

TEST_CASE("whatever the device sends, its command is finite, within its limits, and zero when it is idle") {
  std::uint64_t forceful = 0, faults = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    Chaos chaos(seed);
    const haptics::DeviceProperties& device = chaos.loop.config().device;
    Wrenchd last;
    std::uint32_t idle_ticks = 0;
    Fault last_fault = Fault::kNone;
    for (std::uint64_t t = 0; t < 1000; ++t) {
      chaos.tick();
      const auto& command = chaos.out.command;
      CAPTURE(seed, t);
      REQUIRE(command.sequence == t + 1);
      REQUIRE(is_finite(command.wrench));
      REQUIRE(norm(command.wrench.force) <= device.max_force_N);
      REQUIRE(norm(command.wrench.torque) <= device.max_torque_Nm);
      REQUIRE(norm(command.wrench.force) <= norm(last.force) + 5.0 + 1e-9);  // 5000 N/s
      REQUIRE((command.wanted == DeviceState::kIdle || command.wanted == DeviceState::kForce ||
               command.wanted == DeviceState::kBrake));
      idle_ticks = command.wanted == DeviceState::kForce ? 0 : idle_ticks + 1;
      if (idle_ticks > 6) REQUIRE(command.wrench == Wrenchd{});  // 30 N at 5 N a tick
      if (command.wanted == DeviceState::kBrake) {
        REQUIRE(command.wrench == Wrenchd{});
        REQUIRE(command.rearm == 0);
        REQUIRE(chaos.out.fault != Fault::kNone);
      }
      // A fault goes only with a re-arm.
      if (chaos.out.fault != last_fault)
        REQUIRE((last_fault == Fault::kNone || (chaos.in.operator_bits & kRearm) != 0));
      if (norm(command.wrench.force) > 1) ++forceful;
      if (chaos.out.fault != last_fault && chaos.out.fault != Fault::kNone) ++faults;
      last = command.wrench;
      last_fault = chaos.out.fault;
    }
  }
  CHECK(forceful > 1000);  // the walk is worth something
  CHECK(faults > 30);
}

TEST_CASE("a loop restored at any tick has the same output, byte by byte") {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Chaos original(seed);
    auto copy = std::make_unique<Chaos>(seed);
    for (int t = 0; t < 300; ++t) {
      if (t % 37 == 20) {  // into a new loop, which has seen nothing
        const auto bytes = saved(original.loop);
        copy = std::make_unique<Chaos>(seed);
        ByteReader in(bytes);
        REQUIRE(copy->loop.restore(in));
        REQUIRE(in.remaining() == 0);
      }
      original.tick();
      copy->loop.tick(original.in, copy->out);
      CAPTURE(seed, t);
      REQUIRE(test::same_bits(original.out, copy->out));
      REQUIRE(saved(original.loop) == saved(copy->loop));
    }
  }
}

TEST_CASE("a loop restored under a force beyond one tick's slew goes on with it") {
  Bench bench;
  bench.tool = {{0.05, -0.02, 0.01}, {}};
  bench.hold({5e-3, 0, 0});
  const auto bytes = saved(bench.loop);
  HapticLoop copy(make_config(), {});
  ByteReader in(bytes);
  REQUIRE(copy.restore(in));
  for (int i = 0; i < 20; ++i) {
    bench.tick();
    TickOutput out;
    copy.tick(bench.in, out);
    REQUIRE(test::same_bits(bench.out, out));
    REQUIRE(norm(out.command.wrench.force) > 9);
  }
}

TEST_CASE("a tick depends on its input and the state alone: gone back and done again it is the same") {
  Chaos chaos(3);
  for (int t = 0; t < 200; ++t) {
    const auto before = saved(chaos.loop);
    chaos.tick();
    const TickOutput first = chaos.out;
    const auto after = saved(chaos.loop);
    ByteReader in(before);
    REQUIRE(chaos.loop.restore(in));
    std::memset(static_cast<void*>(&chaos.out), 0xa5, sizeof chaos.out);  // written whole
    chaos.loop.tick(chaos.in, chaos.out);
    REQUIRE(test::same_bits(first, chaos.out));
    REQUIRE(saved(chaos.loop) == after);
  }
}

TEST_CASE("bytes that are cut short are no loop") {
  Chaos chaos(1);
  for (int t = 0; t < 20; ++t) chaos.tick();
  const auto bytes = saved(chaos.loop);
  for (std::size_t size = 0; size < bytes.size(); size += 5) {
    ByteReader in(std::span<const std::byte>(bytes).first(size));
    REQUIRE_FALSE(chaos.loop.restore(in));
  }
}

TEST_CASE("a tick neither allocates nor locks") {
  Chaos chaos(2);
  for (int t = 0; t < 50; ++t) chaos.tick();
  const test::RtGuard guard;
  for (int t = 0; t < 200; ++t) chaos.tick();
  const auto allocations = guard.allocations(), locks = guard.locks();
  CHECK(allocations == 0);
  CHECK(locks == 0);
}
