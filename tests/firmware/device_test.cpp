#include "firmware/device.h"

#include <cmath>
#include <limits>
#include <random>

#include "tests/firmware/device_bench.h"

using namespace tactus::firmware;

TEST_CASE("a device with a plain configuration does what its controller alone does, bit by bit") {
  std::mt19937_64 random(1);
  const DeviceConfig config = bench_config();
  Device device(config.control);
  Controller controller(config.control);
  ControllerInputs inputs;
  std::uniform_real_distribution<float> effort(-15.0f, 15.0f);
  for (std::uint32_t i = 1; i < 20000; ++i) {
    inputs.time_us += 1000;
    inputs.emergency_stop = random() % 500 == 0;
    inputs.motor_bus_ok = random() % 500 != 0;
    for (auto& count : inputs.counts) count += static_cast<std::int32_t>(random() % 300) - 150;
    CommandFrame command{random() % 3 == 0 ? State::kIdle : State::kForce, random() % 7 == 0, i, {}};
    for (float& e : command.effort) e = effort(random);
    std::array<std::byte, kCommandFrameSize> bytes{};
    encode_command(command, bytes);
    const std::size_t size = random() % 4 == 0 ? 0 : bytes.size();
    const auto a = device.step(inputs, std::span(bytes).first(size));
    const auto b = controller.step(inputs, std::span(bytes).first(size));
    REQUIRE(a.effort == b.effort);
    REQUIRE(a.brake == b.brake);
    REQUIRE(a.state_frame == b.state_frame);
  }
}

TEST_CASE("a device reports its identity") {
  DeviceBench b(bench_config(), make_identity(MechanismClass::kVirtuose6, "TACTUS-0042"));
  CHECK(b.read(number::kProtocol) == kProtocolVersion);
  CHECK(b.read(number::kRevision) == kRegisterRevision);
  CHECK(b.read(number::kFirmware) == kFirmwareVersion);
  CHECK(b.read(number::kDeviceClass) == 2);
  CHECK(b.read(number::kAxisCount) == 6);
  CHECK(b.read(number::kPeriod) == 1000);
  std::string serial;
  for (unsigned k = 0; k < 4; ++k)
    for (unsigned i = 0; i < 4; ++i) serial += static_cast<char>((b.read(number::kSerial + k) >> (8 * i)) & 0xff);
  CHECK(serial == std::string("TACTUS-0042\0\0\0\0\0", 16));
}

TEST_CASE("each way of asking wrongly has its own status, and changes nothing") {
  DeviceBench b;
  b.nothing();
  const float before = b.read_real(number::kMaxForce);
  CHECK(b.ask(Operation::kRead, 0x0fff).status == ServiceStatus::kNoSuchRegister);
  CHECK(b.write(number::kState, 1u) == ServiceStatus::kReadOnly);
  CHECK(b.write(number::kPeriod, 500u) == ServiceStatus::kReadOnly);
  CHECK(b.write(number::kMaxForce, -1.0f) == ServiceStatus::kOutOfRange);
  CHECK(b.write(number::kMaxForce, std::numeric_limits<float>::quiet_NaN()) == ServiceStatus::kOutOfRange);
  CHECK(b.write(number::kMaxForce, std::numeric_limits<float>::infinity()) == ServiceStatus::kOutOfRange);
  CHECK(b.ask(static_cast<Operation>(9), number::kMaxForce, 0).status == ServiceStatus::kNoSuchOperation);
  CHECK(b.execute(number::kMaxForce) == ServiceStatus::kNoSuchOperation);
  CHECK(b.write(number::kSave, 0u) == ServiceStatus::kNoSuchOperation);
  CHECK(b.execute(number::kHome, 3) == ServiceStatus::kOutOfRange);
  CHECK(b.read_real(number::kMaxForce) == before);
  CHECK(b.read(number::kSave) == 0);
}

TEST_CASE("a write that contradicts another register is refused") {
  DeviceBench b;
  CHECK(b.write(number::kFadeFrames, 10u) == ServiceStatus::kOutOfRange);  // brake_frames is 10
  CHECK(b.write(number::kBrakeFrames, 3u) == ServiceStatus::kOutOfRange);
  CHECK(b.write(number::kBrakeFrames, 20u) == ServiceStatus::kGood);
  CHECK(b.write(number::kFadeFrames, 10u) == ServiceStatus::kGood);
  CHECK(b.write(number::kThermalLimit, 80.0f) == ServiceStatus::kOutOfRange);  // no warning, no time constant yet
  CHECK(b.write(number::kThermalWarning, 60.0f) == ServiceStatus::kGood);
  CHECK(b.write(number::kThermalTime, 100.0f) == ServiceStatus::kGood);
  CHECK(b.write(number::kThermalLimit, 80.0f) == ServiceStatus::kGood);
  CHECK(b.write(number::kThermalWarning, 80.0f) == ServiceStatus::kOutOfRange);
  CHECK(b.write(number::kDirection, 0) == ServiceStatus::kOutOfRange);
  CHECK(b.write(number::kDirection, -1) == ServiceStatus::kGood);
}

TEST_CASE("a write reads back at once and acts from the next period on") {
  DeviceBench b;
  b.nothing();
  REQUIRE(b.write(number::kMaxForce, 2.0f) == ServiceStatus::kGood);
  CHECK(b.read_real(number::kMaxForce) == 2.0f);
  CHECK(b.device.controller().config().max_force_N == 12.0f);
  b.nothing();
  CHECK(b.device.controller().config().max_force_N == 2.0f);
  b.start_force({8, 0, 0, 0, 0, 0});
  CHECK(b.outputs.effort[0] == 2.0f);
}

TEST_CASE("in FORCE nothing is written") {
  DeviceBench b;
  b.start_force();
  REQUIRE(b.state() == State::kForce);
  for (const Register& row : all_registers()) {
    CAPTURE(row.name);
    if (row.access == Access::kReadWrite) CHECK(b.write(row.number, row.low) == ServiceStatus::kWrongState);
    if (row.access == Access::kCommand) CHECK(b.execute(row.number) == ServiceStatus::kWrongState);
  }
}

TEST_CASE("a device with a bad configuration can be mended register by register") {
  DeviceConfig config = bench_config();
  config.control.quantum[2] = 0;
  config.control.max_speed[4] = 0;
  DeviceBench b(config);
  b.nothing(3);
  CHECK(b.state() == State::kReset);
  CHECK(b.fault() == Fault::kBadConfiguration);
  CHECK(b.device.fault_log().total() == 1);
  CHECK(b.write(number::kQuantum + 2, 1e-5f) == ServiceStatus::kGood);
  b.nothing();
  CHECK(b.state() == State::kReset);
  CHECK(b.write(number::kMaxSpeed + 4, 20.0f) == ServiceStatus::kGood);
  b.nothing();
  CHECK(b.state() == State::kIdle);
  CHECK(b.fault() == Fault::kNone);
}

TEST_CASE("parts whose configuration is not valid keep the device in BRAKE until it does") {
  DeviceConfig config = bench_config();
  config.encoders.direction[3] = 0;
  config.thermal.limit_K[1] = 50;
  DeviceBench b(config);
  b.nothing();
  CHECK(b.state() == State::kBrake);
  CHECK(b.fault() == Fault::kBadConfiguration);
  REQUIRE(b.write(number::kDirection + 3, 1) == ServiceStatus::kGood);
  b.rearm();
  CHECK(b.state() == State::kBrake);
  REQUIRE(b.write(number::kThermalLimit + 1, 0.0f) == ServiceStatus::kGood);
  b.command(State::kIdle);
  b.rearm();
  CHECK(b.state() == State::kIdle);
}

TEST_CASE("the factory's configuration comes back on command") {
  DeviceBench b;
  REQUIRE(b.write(number::kMaxForce, 2.0f) == ServiceStatus::kGood);
  b.nothing();
  REQUIRE(b.execute(number::kFactory) == ServiceStatus::kGood);
  b.nothing();
  CHECK(b.device.controller().config().max_force_N == 12.0f);
}

TEST_CASE("a restored device runs with the saved configuration, and every broken byte of it is detected") {
  DeviceBench b;
  REQUIRE(b.write(number::kMaxForce, 3.0f) == ServiceStatus::kGood);
  REQUIRE(b.write(number::kDirection + 1, -1) == ServiceStatus::kGood);
  REQUIRE(b.write(number::kCanNodeId, 9u) == ServiceStatus::kGood);
  REQUIRE(b.write(number::kFadeFrames, 5u) == ServiceStatus::kGood);
  CHECK(b.execute(number::kSave) == ServiceStatus::kBusy);  // not in force yet
  b.nothing();
  REQUIRE(b.execute(number::kSave) == ServiceStatus::kGood);
  CHECK(b.write(number::kMaxForce, 4.0f) == ServiceStatus::kBusy);
  CHECK(b.read(number::kSaveState) == 1);
  int periods = 0;
  while (b.device.block_to_store().empty() && periods < 1000) {
    b.nothing();
    ++periods;
  }
  REQUIRE(periods < 1000);
  const auto block = b.device.block_to_store();
  std::vector<std::byte> kept(block.begin(), block.end());
  b.device.stored(true);
  CHECK(b.read(number::kSaveState) == 2);
  CHECK(b.device.block_to_store().empty());
  CHECK(b.write(number::kMaxForce, 4.0f) == ServiceStatus::kGood);

  DeviceBench fresh;
  REQUIRE(fresh.device.restore(kept));
  CHECK(fresh.device.controller().config().max_force_N == 3.0f);
  CHECK(fresh.device.encoders().config().direction[1] == -1);
  CHECK(fresh.device.config().bus.can_node_id == 9);
  CHECK(fresh.device.controller().config().fade_frames == 5);
  fresh.nothing(200);
  CHECK(fresh.read(number::kSelfTestFailed) == 0);

  DeviceBench empty;
  CHECK_FALSE(empty.device.restore({}));
  CHECK(empty.read(number::kSelfTestFailed) == 0);  // nothing was ever saved: nothing is wrong
  for (std::size_t i = 0; i < kept.size(); ++i) {
    auto broken = kept;
    broken[i] ^= std::byte{0x10};
    DeviceBench other;
    REQUIRE_FALSE(other.device.restore(broken));
    REQUIRE(other.device.controller().config().max_force_N == 12.0f);
    REQUIRE((other.read(number::kSelfTestFailed) & static_cast<unsigned>(SelfTestBit::kStoredConfiguration)) != 0);
  }
}

TEST_CASE("a board without storage reports that it saves nothing") {
  DeviceBench b;
  b.nothing();
  REQUIRE(b.execute(number::kSave) == ServiceStatus::kGood);
  while (b.device.block_to_store().empty()) b.nothing();
  b.device.stored(false);
  CHECK(b.read(number::kSaveState) == 3);
  CHECK(b.write(number::kMaxForce, 4.0f) == ServiceStatus::kGood);
}

TEST_CASE("the log contains number, state before, axis, time and value, newest first, over a re-arm") {
  DeviceBench b;
  b.start_force();
  b.inputs.counts[4] -= 250;  // 25 rad/s, of 20
  b.command(State::kForce);
  REQUIRE(b.fault() == Fault::kOverspeed);
  const std::uint64_t time_us = b.inputs.time_us;
  b.rearm();
  REQUIRE(b.state() == State::kIdle);
  b.inputs.emergency_stop = true;
  b.nothing();
  b.inputs.emergency_stop = false;
  CHECK(b.read(number::kFaultTotal) == 2);
  CHECK(b.read(number::kFaultLog) == (2u | (1u << 16) | (255u << 24)));  // e-stop, from IDLE
  CHECK(b.read(number::kFaultLog + 4) == (3u | (2u << 16) | (4u << 24)));
  CHECK(b.read(number::kFaultLog + 5) == time_us);
  CHECK(b.read(number::kFaultLog + 6) == 0);
  CHECK(b.read_real(number::kFaultLog + 7) == Approx(-25.0f));
  CHECK(b.read(number::kFaultLog + 8) == 255u << 24);  // none
}

TEST_CASE("a BRAKE that the host requests is not logged, lost commands are") {
  DeviceBench b;
  b.start_force();
  b.command(State::kBrake);
  CHECK(b.device.fault_log().total() == 0);
  b.rearm();
  b.command(State::kForce);
  b.nothing(10);
  REQUIRE(b.device.fault_log().total() == 1);
  CHECK(b.device.fault_log().entry(0).fault == Fault::kCommandsLost);
  CHECK(b.device.fault_log().entry(0).value == 10.0f);
}

TEST_CASE("diagnosis registers have the values of the state frame") {
  DeviceBench b;
  b.start_force({100, 0, 0, 0, 0, 0});
  b.nothing(4);
  CHECK(b.read(number::kState) == 2);
  CHECK(b.read(number::kFault) == 0);
  CHECK(b.read(number::kLimits) == b.frame.limits);
  CHECK(b.read(number::kMissedCommands) == 4);
  CHECK(b.read(number::kRefusedFrames) == 0);
  std::array<std::byte, 7> noise{};
  b.step(noise);
  CHECK(b.read(number::kRefusedFrames) == 1);
  CHECK(b.read(number::kDecodeError) == static_cast<unsigned>(DecodeError::kWrongSize));
  b.inputs.time_us = 7'100'000;
  b.nothing();
  CHECK(b.read(number::kUptime) == 7);
}

TEST_CASE("the e-stop zeroes every effort in its own period, arm support included") {
  DeviceConfig config = bench_config();
  config.gravity.constant = {1, 2, 3, 0, 0, 0};
  config.gravity.in_idle = 1;
  DeviceBench b(config);
  b.start_force({1, 1, 1, 0, 0, 0});
  REQUIRE(b.outputs.effort[2] == 4.0f);
  b.inputs.emergency_stop = true;
  b.command(State::kForce, {1, 1, 1, 0, 0, 0});
  CHECK(b.outputs.effort == AxisValues{});
  CHECK(b.outputs.brake);
}
