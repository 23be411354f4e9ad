// Which faults latch and which only fade the force, how the force ends, and what re-arms it.
#include <catch2/catch.hpp>
#include <memory>

#include "rt/loop/haptic_loop.h"
#include "tests/rt/loop/haptic_loop_bench.h"

using namespace tactus;
using namespace tactus::loop;
using namespace tactus::test::haptic_loop_bench;

namespace {

struct Cause {
  Fault fault;
  ReadStatus status;
  int ticks;  // until it latches
};

// One tick of a device that is in the state that ends in `cause`.
void fail(Bench& bench, const Cause& cause) {
  auto& sample = bench.in.device.sample;
  switch (cause.fault) {
    case Fault::kInputNotFinite:
      bench.tool.position.y = kNaN;
      break;
    case Fault::kInputRotation:
      bench.tool.rotation.w = 1.1;
      break;
    case Fault::kInputWorkspace:
      bench.tool.position = {0, 0, 5};
      break;
    case Fault::kInputJump:
      bench.tool.position = {0, 0.1, 0};
      break;
    case Fault::kDeviceFault:
      sample.device_fault = 3;
      break;
    case Fault::kEmergencyStop:
      sample.device_fault = kEmergencyStop;
      break;
    case Fault::kDeviceBrake:
      sample.state = DeviceState::kBrake;
      break;
    default:
      break;
  }
  bench.tick(0, cause.status);
}

}  // namespace

TEST_CASE("any fault latches, takes the force to zero within ten ticks, brakes, and only a re-arm takes it back") {
  const Cause cause = GENERATE(
      Cause{Fault::kLinkLost, ReadStatus::kMissing, 10}, Cause{Fault::kDeviceUnplugged, ReadStatus::kDisconnected, 1},
      Cause{Fault::kInputNotFinite, ReadStatus::kFresh, 3}, Cause{Fault::kInputRotation, ReadStatus::kFresh, 3},
      Cause{Fault::kInputWorkspace, ReadStatus::kFresh, 3}, Cause{Fault::kInputJump, ReadStatus::kFresh, 3},
      Cause{Fault::kDeviceFault, ReadStatus::kFresh, 1}, Cause{Fault::kEmergencyStop, ReadStatus::kFresh, 1},
      Cause{Fault::kDeviceBrake, ReadStatus::kFresh, 1});
  CAPTURE(static_cast<std::uint32_t>(cause.fault));
  Bench bench;
  bench.hold({2e-3, 1e-3, 0});
  REQUIRE(bench.force() > 4);

  for (int i = 1; i < cause.ticks; ++i) {
    fail(bench, cause);
    REQUIRE(bench.out.fault == Fault::kNone);
  }
  double last = bench.force();
  for (int i = 0; i < 10; ++i) {
    fail(bench, cause);
    CHECK(bench.out.fault == cause.fault);
    CHECK(bench.force() <= last);
    last = bench.force();
  }
  CHECK(bench.out.command.wrench == Wrenchd{});
  CHECK(bench.out.command.wanted == DeviceState::kBrake);

  // The cause is gone, and kArm is requested: the fault stays latched.
  bench.tool = {{2e-3, 1e-3, 0}, {}};
  bench.in.device.sample.device_fault = 0;
  bench.in.device.sample.state = DeviceState::kBrake;
  for (int i = 0; i < 100; ++i) {
    bench.tick(kArm);
    REQUIRE(bench.out.fault == cause.fault);
    REQUIRE(bench.out.command.wrench == Wrenchd{});
    REQUIRE(bench.out.command.wanted == DeviceState::kBrake);
    REQUIRE(bench.out.command.rearm == 0);
    REQUIRE((bench.out.status & kNotArmed) != 0);
  }

  bench.force_step_max = 0;
  bench.tick(kRearm);
  CHECK(bench.out.fault == Fault::kNone);
  CHECK(bench.out.command.rearm == 1);
  CHECK(bench.out.command.wanted != DeviceState::kBrake);
  bench.tick();
  CHECK(bench.out.command.wanted == DeviceState::kForce);
  check_close(bench.out.target.position, bench.out.proxy.pose.position, 1e-10);
  bench.move({1e-3, 0, 0});
  bench.run(250);
  CHECK(bench.out.command.rearm == 0);
  CHECK(bench.out.fault == Fault::kNone);
  check_close(bench.out.command.wrench.force, {-kStiffness * 1e-3, 0, 0}, 1e-6);
  CHECK(bench.force_step_max < 0.25);  // the ramp: at most 2 N and the damping's 2.5 N, over 200 ticks
}

TEST_CASE("missing frames fade the force by a tenth a tick, and it comes back by the ramp") {
  Bench bench;
  bench.hold({5e-3, 0, 0});
  const double whole = kStiffness * 5e-3;
  for (int missed = 1; missed <= 8; ++missed) {
    bench.tick(0, ReadStatus::kMissing);
    CHECK(bench.force() == Approx(whole * (1 - 0.1 * missed)).epsilon(1e-5));
    CHECK(((bench.out.status & kForceFading) != 0) == (missed >= 3));
  }
  for (int i = 1; i <= 80; ++i) {  // 0.1 s from nothing to all
    bench.tick();
    CHECK(bench.force() == Approx(whole * (0.2 + i / 100.0)).epsilon(1e-5));
  }
  bench.tick();
  CHECK(bench.force() == Approx(whole).epsilon(1e-5));
  CHECK((bench.out.status & kSlewLimited) == 0);
  CHECK(bench.out.fault == Fault::kNone);
}

TEST_CASE("one or two missing frames are no fade: the force comes back as it went, a tenth a tick") {
  Bench bench;
  bench.hold({5e-3, 0, 0});
  const double whole = kStiffness * 5e-3;
  for (const double share : {0.9, 0.8}) {
    bench.tick(0, ReadStatus::kMissing);
    CHECK(bench.force() == Approx(whole * share).epsilon(1e-5));
  }
  for (const double share : {0.9, 1.0}) {
    bench.tick();
    CHECK(bench.force() == Approx(whole * share).epsilon(1e-5));
  }
}

TEST_CASE("a device that misses commands fades, and the next command is no more than the force that is left") {
  Bench bench;
  bench.hold({5e-3, 0, 0});
  const double whole = kStiffness * 5e-3;
  auto& missed = bench.in.device.sample.missed_commands;
  for (missed = 1; missed <= 2; ++missed) {
    bench.tick();
    CHECK(bench.force() == Approx(whole).epsilon(1e-5));
  }
  // The host was suspended: the first sample that it reads reports seven missed commands.
  missed = 7;
  bench.tick();
  CHECK(bench.force() == Approx(0.3 * whole).epsilon(1e-5));
  missed = 0;
  double last = bench.force();
  for (int i = 0; i < 71; ++i) {  // 0.1 s from nothing to all
    bench.tick();
    CHECK(bench.force() - last <= 0.0101 * whole);
    last = bench.force();
  }
  CHECK(last == Approx(whole).epsilon(1e-5));
}

TEST_CASE("a device that leaves FORCE by itself is a fault at once, and only a re-arm gives force again, by the ramp") {
  const auto left = GENERATE(DeviceState::kIdle, DeviceState::kReset);
  Bench bench;
  bench.hold({5e-3, 0, 0});
  REQUIRE(bench.force() > 9);
  bench.in.device.sample.state = left;  // in one sample; the next reports FORCE again
  bench.tick();
  CHECK(bench.out.fault == Fault::kDeviceLeftForce);
  CHECK(bench.out.command.wrench == Wrenchd{});
  CHECK(bench.out.command.wanted == DeviceState::kBrake);
  for (int i = 0; i < 100; ++i) {
    bench.tick(kArm);
    REQUIRE(bench.out.fault == Fault::kDeviceLeftForce);
    REQUIRE(bench.out.command.wrench == Wrenchd{});
  }
  bench.force_step_max = 0;
  bench.tick(kRearm);
  bench.tick();
  bench.move({5e-3, 0, 0});
  bench.run(250);
  CHECK(bench.out.fault == Fault::kNone);
  CHECK(bench.force() == Approx(kStiffness * 5e-3).epsilon(1e-5));
  CHECK(bench.force_step_max < 0.25);
}

TEST_CASE("a device that accepts commands and refuses FORCE is a fault, and stays free to be moved") {
  Bench bench;
  bench.run(3);
  bench.tick(kArm);
  int ticks = 0;
  for (; bench.out.fault == Fault::kNone && ticks < 20; ++ticks) {
    bench.in.device.sample.state = DeviceState::kIdle;
    bench.tick();
  }
  CHECK(ticks == 3);
  CHECK(bench.out.fault == Fault::kForceRefused);
  for (int i = 0; i < 100; ++i) {
    bench.tick();
    REQUIRE(bench.out.command.wrench == Wrenchd{});
    REQUIRE(bench.out.command.wanted == DeviceState::kIdle);
  }
  bench.force_step_max = 0;
  bench.tick(kRearm);
  bench.tick();
  bench.move({5e-3, 0, 0});
  bench.run(250);
  CHECK(bench.out.fault == Fault::kNone);
  CHECK(bench.force() > 9);
  CHECK(bench.force_step_max < 0.25);
}

TEST_CASE(
    "at the end of a run the force fades without a step, then the device is told to go to IDLE, and nothing arms") {
  Bench bench;
  bench.hold({5e-3, 0, 0});
  REQUIRE(bench.force() > 9);
  bench.force_step_max = 0;
  for (int i = 0; i < 50; ++i) bench.tick(loop::kEnd);
  CHECK(bench.force_step_max < 0.21);
  CHECK(bench.out.command.wrench == Wrenchd{});
  for (int i = 0; i < 50; ++i) {
    bench.tick(loop::kEnd | kArm);
    REQUIRE(bench.out.command.wanted == DeviceState::kIdle);
    REQUIRE(bench.out.command.wrench == Wrenchd{});
    REQUIRE(bench.out.fault == Fault::kNone);
  }
}

TEST_CASE("a device that has not received the request for FORCE yet refuses nothing, and one may leave on request") {
  Bench bench;
  bench.run(3);
  bench.deaf = true;
  bench.tick(kArm);
  for (int i = 0; i < 50; ++i) {
    bench.in.device.sample.state = DeviceState::kIdle;
    bench.tick();
    REQUIRE(bench.out.fault == Fault::kNone);
  }
  bench.deaf = false;
  bench.run(300);
  CHECK(bench.out.command.wanted == DeviceState::kForce);
  // Off and on again while the commands are under way: it goes to IDLE and back as it was told.
  bench.tick(loop::kDisarm);
  const auto heard = bench.out.command.sequence;
  bench.deaf = true;
  bench.tick(kArm);
  for (const auto state : {DeviceState::kForce, DeviceState::kIdle, DeviceState::kForce}) {
    bench.in.device.sample.state = state;
    bench.in.device.sample.echoed_sequence = state == DeviceState::kForce ? heard - 1 : heard;
    bench.tick();
    REQUIRE(bench.out.fault == Fault::kNone);
  }
}

TEST_CASE("a fault while idle brakes at once") {
  Bench bench;
  bench.run(3);
  bench.tick(0, ReadStatus::kDisconnected);
  CHECK(bench.out.fault == Fault::kDeviceUnplugged);
  CHECK(bench.out.command.wanted == DeviceState::kBrake);
  CHECK(bench.out.command.wrench == Wrenchd{});
}

TEST_CASE("a wrench of our own that is no number is never sent, latches and brakes at once") {
  // Interpolation has no solver that limits the stretch: 1e308 N/m times 10 m overflows.
  LoopConfig config = make_config(CouplingScheme::kInterpolation);
  config.sub_world.gains.stiffness_N_per_m = 1e308;
  config.placement.motion_scale = 1e4;
  Bench bench(config);
  const auto snapshot = std::make_unique<haptics::WorldSnapshot>();
  const auto report = std::make_unique<haptics::SubWorldReport>();
  bench.in.snapshot = snapshot.get();
  bench.in.sink.report = report.get();
  bench.tick();
  bench.in.snapshot = nullptr;
  bench.tick(kArm);
  bench.run(2);
  REQUIRE(bench.out.command.wanted == DeviceState::kForce);
  bench.tool.position.x = 1e-3;
  bench.tick();
  CHECK_FALSE(is_finite(bench.out.wanted));
  CHECK(bench.out.fault == Fault::kOutputNotFinite);
  CHECK(bench.out.command.wrench == Wrenchd{});
  CHECK(bench.out.command.wanted == DeviceState::kBrake);
  // Finite again, and arming: still latched.
  bench.tool.position.x = 0;
  for (int i = 0; i < 30; ++i) {
    bench.in.device.sample.state = DeviceState::kIdle;  // not the device's own latch
    bench.tick(i > 5 ? kArm : 0u);
    REQUIRE(bench.out.fault == Fault::kOutputNotFinite);
    REQUIRE(bench.out.command.wrench == Wrenchd{});
    REQUIRE(bench.out.command.wanted == DeviceState::kBrake);
  }
  bench.tick(kRearm);
  CHECK(bench.out.fault == Fault::kNone);
}

TEST_CASE("the re-arm flag rises once and falls when the device has left BRAKE") {
  Bench bench;
  bench.hold({1e-3, 0, 0});
  for (int i = 0; i < 12; ++i) bench.tick(0, ReadStatus::kDisconnected);
  auto& state = bench.in.device.sample.state;
  state = DeviceState::kBrake;
  // The device takes 20 ticks to hear of it.
  std::uint32_t before = 0;
  int rises = 0;
  for (int i = 0; i < 60; ++i) {
    bench.tick(i == 0 ? kRearm : 0u);
    if (bench.out.command.rearm != 0 && before == 0) ++rises;
    before = bench.out.command.rearm;
    CHECK(before == (i < 20 ? 1u : 0u));
    CHECK(bench.out.command.wanted == (i < 20 ? DeviceState::kIdle : DeviceState::kForce));
    state = i < 19 ? DeviceState::kBrake : bench.out.command.wanted;
  }
  CHECK(rises == 1);
}

TEST_CASE("a device that stays in BRAKE is not engaged, and a second re-arm is a rise again") {
  Bench bench;
  bench.hold({1e-3, 0, 0});
  for (int i = 0; i < 12; ++i) bench.tick(0, ReadStatus::kDisconnected);
  std::uint32_t before = 0;
  int rises = 0;
  for (int i = 0; i < 300; ++i) {
    bench.in.device.sample.state = DeviceState::kBrake;
    bench.tick(i % 100 == 0 ? kRearm : 0u);
    if (bench.out.command.rearm != 0 && before == 0) ++rises;
    before = bench.out.command.rearm;
    REQUIRE(bench.out.command.wanted != DeviceState::kForce);
    REQUIRE(bench.out.command.wrench == Wrenchd{});
    REQUIRE((bench.out.status & kNotArmed) != 0);
  }
  CHECK(rises == 3);
}

TEST_CASE("a device that begins in BRAKE needs a re-arm") {
  Bench bench;
  bench.in.device.sample.state = DeviceState::kBrake;
  for (int i = 0; i < 30; ++i) {
    bench.in.device.sample.state = DeviceState::kBrake;
    bench.tick(kArm);
    REQUIRE(bench.out.command.wanted == DeviceState::kIdle);
  }
  bench.in.device.sample.state = DeviceState::kBrake;
  bench.tick(kRearm);
  CHECK(bench.out.command.rearm == 1);
  bench.tick();
  CHECK(bench.out.command.wanted == DeviceState::kForce);
}

TEST_CASE("a fault that comes back takes the re-arm flag with it") {
  Bench bench;
  bench.hold({1e-3, 0, 0});
  for (int i = 0; i < 12; ++i) bench.tick(0, ReadStatus::kDisconnected);
  bench.in.device.sample.state = DeviceState::kBrake;
  bench.tick(kRearm);
  REQUIRE(bench.out.command.rearm == 1);
  bench.tick(0, ReadStatus::kDisconnected);
  CHECK(bench.out.fault == Fault::kDeviceUnplugged);
  CHECK(bench.out.command.rearm == 0);
}
