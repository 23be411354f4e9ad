#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <random>
#include <vector>

#include "firmware/boards/cortex_m/board_mechanics.h"
#include "firmware/boards/cortex_m/board_storage.h"
#include "firmware/boards/cortex_m/configuration.h"

using namespace tactus::firmware;
using namespace tactus::firmware::cortex_m;

namespace {

constexpr std::uint32_t kClock_Hz = 25'000'000, kPeriod_us = 1000, kCountsPerPeriod = 25'000;

struct Bench {
  BoardRegisters registers{};
  SysTickRegisters timer{};
  PeriodClock clock;
  BoardMechanics mechanics{registers, clock, {10, 10, 10, 2, 2, 0}};

  Bench() {
    REQUIRE(clock.start(timer, kClock_Hz, kPeriod_us));
    timer.current = timer.reload;
  }
  ControllerInputs sample() {
    ControllerInputs inputs;
    mechanics.sample(inputs);
    return inputs;
  }
  std::int32_t setpoint(unsigned axis) const { return static_cast<std::int32_t>(registers.motor_setpoint[axis]); }
  MotorStage stage() const { return static_cast<MotorStage>(registers.motor_stage); }
  void drive(const AxisValues& effort, bool brake = false) {
    ControllerOutputs outputs;
    outputs.effort = effort;
    outputs.brake = brake;
    mechanics.drive(outputs);
  }
};

}  // namespace

TEST_CASE("a board to which nothing is connected is stopped and without supply") {
  Bench b;
  const ControllerInputs inputs = b.sample();
  CHECK(inputs.emergency_stop);
  CHECK_FALSE(inputs.motor_bus_ok);
}

TEST_CASE("the controller receives the contents of the registers") {
  Bench b;
  b.registers.pins = kPinStopReleased | kPinSupplyGood | 0xa5u << kFirstButtonPin;
  for (unsigned i = 0; i < kAxes; ++i) {
    b.registers.encoder_count[i] = static_cast<std::uint32_t>(-100 * static_cast<std::int32_t>(i));
    b.registers.winding_rise_mK[i] = 1500 * i;
  }
  b.registers.encoder_errors = 0xfffffff0u | 1u << 5;
  const ControllerInputs inputs = b.sample();
  CHECK_FALSE(inputs.emergency_stop);
  CHECK(inputs.motor_bus_ok);
  CHECK(inputs.buttons == 0xa5);
  CHECK(inputs.encoder_errors == 0x30);  // six axes
  for (unsigned i = 0; i < kAxes; ++i) {
    CHECK(inputs.counts[i] == -100 * static_cast<std::int32_t>(i));
    CHECK(inputs.measured_rise_K[i] == Approx(1.5 * i));
  }
}

TEST_CASE("each index pulse is reported once, with the count that it latched") {
  Bench b;
  CHECK(b.sample().index_edges == 0);
  b.registers.index_pulses[2] = 1;
  b.registers.index_count[2] = 77;
  b.registers.index_pulses[4] = 3;
  b.registers.index_count[4] = static_cast<std::uint32_t>(-5);
  const ControllerInputs inputs = b.sample();
  CHECK(inputs.index_edges == (1u << 2 | 1u << 4));
  CHECK(inputs.index_counts[2] == 77);
  CHECK(inputs.index_counts[4] == -5);
  CHECK(b.sample().index_edges == 0);
}

TEST_CASE("pulses from before the program began are none") {
  BoardRegisters registers{};
  registers.index_pulses[1] = 12;
  PeriodClock clock;
  SysTickRegisters timer{};
  REQUIRE(clock.start(timer, kClock_Hz, kPeriod_us));
  BoardMechanics mechanics(registers, clock, {});
  ControllerInputs inputs;
  mechanics.sample(inputs);
  CHECK(inputs.index_edges == 0);
}

TEST_CASE("set-points are efforts in parts of the full effort, to the nearest, and saturate") {
  Bench b;
  std::mt19937_64 random(1);
  std::uniform_real_distribution<float> effort(-15.0f, 15.0f);
  for (int i = 0; i < 20000; ++i) {
    const AxisValues wanted{effort(random), 0, 0, effort(random), 0, effort(random)};
    b.drive(wanted);
    const auto expected = [](float e, double full) {
      return std::clamp(static_cast<double>(e) / full * 32767.0, -32767.0, 32767.0);
    };
    REQUIRE(b.setpoint(0) == Approx(expected(wanted[0], 10.0)).margin(0.502));
    REQUIRE(b.setpoint(3) == Approx(expected(wanted[3], 2.0)).margin(0.502));
    REQUIRE(b.setpoint(5) == 0);  // no motor
    REQUIRE(b.stage() == MotorStage::kDriven);
  }
  const float infinity = std::numeric_limits<float>::infinity();
  b.drive({infinity, -infinity, std::numeric_limits<float>::quiet_NaN(), 0, 0, 0});
  CHECK(b.setpoint(0) == 32767);
  CHECK(b.setpoint(1) == -32767);
  CHECK(b.setpoint(2) == 0);
}

TEST_CASE("no effort leaves the motors without current, a brake shorts them with every set-point zero") {
  Bench b;
  b.drive({});
  CHECK(b.stage() == MotorStage::kOff);
  b.drive({5, 5, 5, 1, 1, 0});
  CHECK(b.stage() == MotorStage::kDriven);
  CHECK(b.setpoint(0) != 0);
  b.drive({5, 5, 5, 1, 1, 0}, true);
  CHECK(b.stage() == MotorStage::kShorted);
  for (unsigned i = 0; i < kAxes; ++i) CHECK(b.setpoint(i) == 0);
}

TEST_CASE("the heartbeat toggles in every period, whatever the state") {
  Bench b;
  for (int i = 0; i < 10; ++i) {
    const std::uint32_t before = b.registers.heartbeat;
    b.drive({}, i % 2 == 0);
    REQUIRE(b.registers.heartbeat != before);
  }
}

TEST_CASE("the clock gives periods and the time within them, and never decreases") {
  Bench b;
  CHECK(b.timer.reload == kCountsPerPeriod - 1);
  std::uint64_t last_us = 0;
  for (std::uint32_t tick = 0; tick < 50; ++tick) {
    for (std::uint32_t elapsed = 0; elapsed < kCountsPerPeriod; elapsed += 997) {
      b.timer.current = b.timer.reload - elapsed;
      const std::uint64_t now_us = b.clock.now_us();
      const double exact_us = 1000.0 * tick + elapsed / 25.0;
      REQUIRE(static_cast<double>(now_us) <= exact_us + 1e-3);
      REQUIRE(static_cast<double>(now_us) > exact_us - 1.001);
      REQUIRE(now_us >= last_us);
      last_us = now_us;
    }
    b.clock.tick();
    b.timer.current = b.timer.reload;  // the counter has restarted before the tick is taken
    REQUIRE(b.clock.now_us() >= last_us);
    REQUIRE(b.clock.take_tick());
    REQUIRE_FALSE(b.clock.take_tick());
  }
  CHECK(b.clock.missed() == 0);
}

TEST_CASE("periods that overran are counted, and the clock stays correct") {
  Bench b;
  for (int i = 0; i < 4; ++i) b.clock.tick();
  CHECK(b.clock.take_tick());
  CHECK_FALSE(b.clock.take_tick());  // no burst to catch up
  CHECK(b.clock.missed() == 3);
  CHECK(b.clock.now_us() == 4 * kPeriod_us);
}

TEST_CASE("a period that the counter cannot hold is refused") {
  SysTickRegisters timer{};
  PeriodClock clock;
  CHECK_FALSE(clock.start(timer, kClock_Hz, 0));
  constexpr std::uint32_t longest = 1u << 24;  // counts, one a microsecond here
  CHECK_FALSE(clock.start(timer, 1'000'000, longest + 1));
  CHECK(timer.control == 0);
  CHECK(clock.start(timer, 1'000'000, longest));
  CHECK(timer.reload == longest - 1);
}

TEST_CASE("the board loads what it stored, and nothing from a memory that was never written") {
  std::mt19937_64 random(2);
  std::array<std::byte, kConfigBlockSize> buffer{};
  for (int i = 0; i < 200; ++i) {
    StorageMemory memory{};
    BoardStorage storage(memory);
    CHECK(storage.load(buffer) == 0);
    std::vector<std::byte> block(random() % (kConfigBlockSize + 1));
    for (auto& b : block) b = static_cast<std::byte>(random());
    REQUIRE(storage.store(block));
    REQUIRE(storage.load(buffer) == block.size());
    REQUIRE(std::equal(block.begin(), block.end(), buffer.begin()));
    memory.size = kConfigBlockSize + 1 + static_cast<std::uint32_t>(random() % 1000000);
    REQUIRE(storage.load(buffer) == 0);
  }
  StorageMemory memory{};
  CHECK_FALSE(BoardStorage(memory).store(std::vector<std::byte>(kConfigBlockSize + 1)));
}

TEST_CASE("the image's configuration is one that the controller accepts") {
  CHECK(is_valid(make_configuration()));
  for (unsigned i = 0; i < kAxes; ++i) CHECK(kFullEffort[i] >= make_configuration().max_effort[i]);
}
