#include "firmware/self_test.h"

#include <vector>

#include "tests/firmware/device_bench.h"

using namespace tactus::firmware;

namespace {

std::uint32_t bit(SelfTestBit b) { return static_cast<std::uint32_t>(b); }

void whole_pass(SelfTest& test, const DeviceConfig& accepted, const DeviceConfig& in_force, bool encoders = true,
                bool bus = true) {
  for (std::uint32_t i = 0; i < test.periods_per_pass(); ++i)
    test.step(accepted.view(), in_force.view(), encoders, bus);
}

}  // namespace

TEST_CASE("a sound device passes, and every pass is counted") {
  SelfTest test;
  const DeviceConfig config = bench_config();
  for (std::uint32_t pass = 1; pass < 5; ++pass) {
    whole_pass(test, config, config);
    CHECK(test.passes() == pass);
    CHECK(test.failed() == 0);
    CHECK_FALSE(test.is_fault());
  }
}

TEST_CASE("any change of any row of the register table is found") {
  const std::vector<Register> good(all_registers().begin(), all_registers().end());
  const DeviceConfig config = bench_config();
  for (std::size_t i = 0; i < good.size(); ++i)
    for (int change = 0; change < 6; ++change) {
      std::vector<Register> table = good;
      Register& row = table[i];
      if (change == 0) row.number ^= 1u;
      if (change == 1) row.high ^= 0x40000000u;
      if (change == 2) row.low ^= 1u;
      if (change == 3) row.states ^= 4u;
      if (change == 4) row.access = row.access == Access::kRead ? Access::kReadWrite : Access::kRead;
      if (change == 5) row.type = row.type == RegisterType::kU32 ? RegisterType::kF32 : RegisterType::kU32;
      SelfTest test(table);
      whole_pass(test, config, config);
      REQUIRE(test.failed() == bit(SelfTestBit::kTables));
      REQUIRE(test.is_fault());
    }
}

TEST_CASE("any value in force that was not accepted is found within one pass, and a good pass clears it") {
  const DeviceConfig accepted = bench_config();
  for (const Register& row : all_registers())
    for (unsigned i = 0; row.section != Section::kNone && i < row.count; ++i) {
      DeviceConfig in_force = accepted;
      write_field(row, i, read_field(row, i, accepted.view()) ^ 1u, in_force);
      SelfTest test;
      whole_pass(test, accepted, in_force);
      REQUIRE((test.failed() & bit(SelfTestBit::kConfiguration)) != 0);
      REQUIRE(test.is_fault());
      whole_pass(test, accepted, accepted);
      REQUIRE_FALSE(test.is_fault());
    }
}

TEST_CASE("encoders and supply that failed during a pass show, and are no fault of the self-test's") {
  SelfTest test;
  const DeviceConfig config = bench_config();
  test.step(config.view(), config.view(), false, true);
  test.step(config.view(), config.view(), true, false);
  for (std::uint32_t i = 2; i < test.periods_per_pass(); ++i) test.step(config.view(), config.view(), true, true);
  CHECK(test.failed() == (bit(SelfTestBit::kEncoders) | bit(SelfTestBit::kMotorBus)));
  CHECK_FALSE(test.is_fault());
}

TEST_CASE("a watchdog whose share does not fall is found") {
  Config config = bench_config().control;
  CHECK(is_watchdog_good(config));
  config.fade_frames = 0;
  CHECK_FALSE(is_watchdog_good(config));
  config.fade_frames = config.brake_frames;
  CHECK_FALSE(is_watchdog_good(config));

  SelfTest test;
  DeviceConfig whole = bench_config();
  whole.control.fade_frames = 0;
  whole_pass(test, whole, whole);
  CHECK(test.failed() == bit(SelfTestBit::kWatchdog));
  CHECK(test.is_fault());
}

TEST_CASE("a bit that flips in the configuration in force brakes the device within a pass, and a write mends it") {
  DeviceBench b;
  b.start_force({1, 0, 0, 0, 0, 0});
  const_cast<Config&>(b.device.controller().config()).max_force_N = 1000.0f;  // cosmic
  std::uint32_t periods = 0;
  while (b.state() == State::kForce && periods < 500) {
    b.command(State::kForce);
    ++periods;
  }
  CHECK(periods <= b.device.self_test().periods_per_pass() + 1);
  CHECK(b.fault() == Fault::kSelfTest);
  CHECK(b.device.fault_log().entry(0).fault == Fault::kSelfTest);
  for (int i = 0; i < 200; ++i) b.command(State::kIdle);
  b.rearm();
  CHECK(b.state() == State::kBrake);
  CHECK(b.read(number::kSelfTestFailed) == bit(SelfTestBit::kConfiguration));
  REQUIRE(b.write(number::kMaxTorque, 1.0f) == ServiceStatus::kGood);
  for (int i = 0; i < 200; ++i) b.command(State::kIdle);
  b.rearm();
  CHECK(b.state() == State::kIdle);
  CHECK(b.device.controller().config().max_force_N == 12.0f);
}

TEST_CASE("the first self-test ends before the first period, and a command starts another pass") {
  DeviceBench b;
  CHECK(b.read(number::kSelfTestPasses) == 1);
  b.nothing(5);
  REQUIRE(b.execute(number::kSelfTest) == ServiceStatus::kGood);
  b.nothing(static_cast<int>(b.device.self_test().periods_per_pass()) - 1);
  CHECK(b.read(number::kSelfTestPasses) == 1);
  b.nothing();
  CHECK(b.read(number::kSelfTestPasses) == 2);
  CHECK(b.read(number::kSelfTestFailed) == 0);
}
