#include "firmware/homing.h"

#include <limits>
#include <random>

#include "tests/firmware/device_bench.h"

using namespace tactus::firmware;

namespace {

constexpr std::int32_t kDistance = 4096;

EncoderConfig indexed() {
  EncoderConfig c;
  c.direction = {1, -1, 1, -1, 1, 1};
  c.index_distance.fill(kDistance);
  c.index_position = {100, 200, 300, -400, -500, -600};
  c.index_axes = kAllAxes;
  c.index_tolerance = 2;
  return c;
}

ControllerInputs inputs_at(const AxisCounts& raw) {
  ControllerInputs inputs;
  inputs.counts = raw;
  return inputs;
}

DeviceBench demanding_bench() {
  DeviceConfig config = bench_config();
  config.encoders = indexed();
  config.encoders.homing_demanded = 1;
  config.encoders.cradle_position = {1000, 2000, 3000, 4000, 5000, 6000};
  return DeviceBench(config);
}

}  // namespace

TEST_CASE("counts are direction times raw plus offset, over the counter's wrap") {
  std::mt19937_64 random(1);
  for (int i = 0; i < 2000; ++i) {
    EncoderConfig c;
    ControllerInputs inputs;
    for (unsigned k = 0; k < kAxes; ++k) {
      c.direction[k] = random() % 2 == 0 ? 1 : -1;
      c.offset[k] = static_cast<std::int32_t>(random());
      inputs.counts[k] = static_cast<std::int32_t>(random());
    }
    Encoders encoders;
    encoders.configure(c);
    const Encoders::Reading reading = encoders.update(inputs);
    for (unsigned k = 0; k < kAxes; ++k) {
      const auto raw = static_cast<std::uint32_t>(inputs.counts[k]);
      const std::uint32_t turned = c.direction[k] > 0 ? raw : 0u - raw;
      REQUIRE(static_cast<std::uint32_t>(reading.counts[k]) == turned + static_cast<std::uint32_t>(c.offset[k]));
    }
  }
}

TEST_CASE("in the cradle every count is the cradle position") {
  EncoderConfig c = indexed();
  c.cradle_position = {1, -2, 3, -4, 5, std::numeric_limits<std::int32_t>::max() / 4};
  Encoders encoders;
  encoders.configure(c);
  const ControllerInputs inputs = inputs_at({77, 88, -99, 12345678, -5, 6});
  encoders.update(inputs);
  CHECK(encoders.state() == HomingState::kNotHomed);
  REQUIRE(encoders.order(HomingOrder::kInCradle));
  CHECK(encoders.state() == HomingState::kHomed);
  const auto reading = encoders.update(inputs);
  CHECK(reading.counts == c.cradle_position);
  CHECK(reading.meaning_changed);
  CHECK(reading.before == c.cradle_position);
  CHECK_FALSE(encoders.update(inputs).meaning_changed);
}

TEST_CASE("by index the offset becomes the one that puts the pulse where pulses are, nearest to the old estimate") {
  std::mt19937_64 random(2);
  for (int i = 0; i < 5000; ++i) {
    EncoderConfig c = indexed();
    // The truth: count = direction raw + offset. The configuration is off by less than half a distance.
    AxisCounts truth{}, raw{};
    ControllerInputs inputs;
    for (unsigned k = 0; k < kAxes; ++k) {
      truth[k] = static_cast<std::int32_t>(random() % 100000) - 50000;
      c.offset[k] = truth[k] + static_cast<std::int32_t>(random() % (kDistance - 2)) - (kDistance / 2 - 1);
      const std::int32_t pulse = c.index_position[k] + kDistance * (static_cast<std::int32_t>(random() % 21) - 10);
      raw[k] = c.direction[k] * (pulse - truth[k]);
    }
    Encoders encoders;
    encoders.configure(c);
    REQUIRE(encoders.order(HomingOrder::kByIndex));
    REQUIRE(encoders.state() == HomingState::kHoming);
    for (unsigned k = 0; k < kAxes; ++k) {
      inputs.index_edges = static_cast<std::uint8_t>(1u << k);
      inputs.index_counts = raw;
      inputs.counts = raw;
      const auto reading = encoders.update(inputs);
      REQUIRE(reading.counts[k] == c.direction[k] * raw[k] + truth[k]);
      REQUIRE(reading.fault_axes == 0);
      REQUIRE(encoders.homed_axes() == (2u << k) - 1);
    }
    REQUIRE(encoders.state() == HomingState::kHomed);
  }
}

TEST_CASE("an axis with one pulse in its range is homed by it, however far off the estimate was") {
  EncoderConfig c;
  c.index_axes = 1;
  c.index_position[0] = 5000;
  Encoders encoders;
  encoders.configure(c);
  REQUIRE(encoders.order(HomingOrder::kByIndex));
  CHECK(encoders.homed_axes() == (kAllAxes & ~1u));  // the others keep what they have
  ControllerInputs inputs = inputs_at({-900010, 0, 0, 0, 0, 0});
  inputs.index_edges = 1;
  inputs.index_counts[0] = -900000;
  CHECK(encoders.update(inputs).counts[0] == 4990);
  CHECK(encoders.state() == HomingState::kHomed);
}

TEST_CASE("the first pulse of an axis is the one that counts") {
  Encoders encoders;
  encoders.configure(indexed());
  REQUIRE(encoders.order(HomingOrder::kByIndex));
  ControllerInputs inputs;
  inputs.index_edges = 1;
  inputs.index_counts[0] = 40;
  const std::int32_t count = encoders.update(inputs).counts[0];
  inputs.index_counts[0] = 42;  // within the tolerance, from the other side
  CHECK(encoders.update(inputs).counts[0] == count);
  CHECK(encoders.state() == HomingState::kHoming);
}

TEST_CASE("an order that is none, or by index without an index, is refused") {
  Encoders encoders;
  CHECK_FALSE(encoders.order(static_cast<HomingOrder>(3)));
  CHECK_FALSE(encoders.order(HomingOrder::kByIndex));
  CHECK(encoders.state() == HomingState::kNotHomed);
}

TEST_CASE("pulses at whole distances are accepted, any other distance is a fault that clears the homing") {
  for (std::int32_t off = -kDistance / 2; off <= kDistance / 2; ++off)
    for (const std::int32_t turns : {-3, 0, 1, 100}) {
      Encoders encoders;
      encoders.configure(indexed());
      REQUIRE(encoders.order(HomingOrder::kInCradle));
      ControllerInputs inputs;
      inputs.index_edges = 1;
      inputs.index_counts[0] = 777;
      REQUIRE(encoders.update(inputs).fault_axes == 0);
      inputs.index_counts[0] = 777 + turns * kDistance + off;
      const bool good = std::abs(off) <= 2;
      REQUIRE(encoders.update(inputs).fault_axes == (good ? 0 : 1));
      REQUIRE((encoders.state() == HomingState::kHomed) == good);
      REQUIRE(encoders.errors(0) == (good ? 0u : 1u));
    }
}

TEST_CASE("one lost count per turn is found before a position is off by more than the tolerance and one turn's loss") {
  Encoders encoders;
  encoders.configure(indexed());
  ControllerInputs inputs;
  inputs.index_edges = 4;
  for (int turn = 0; turn < 10; ++turn) {
    inputs.index_counts[2] = turn * (kDistance - 1);
    const bool faulty = encoders.update(inputs).fault_axes != 0;
    REQUIRE(faulty == (turn == 3));  // off by 3, of 2
    if (faulty) break;
  }
}

TEST_CASE("an encoder's own error flag brakes, counts, and is re-armed only once it is gone") {
  DeviceBench b;
  b.start_force({1, 0, 0, 0, 0, 0});
  b.inputs.encoder_errors = 1u << 5;
  b.command(State::kForce, {1, 0, 0, 0, 0, 0});
  CHECK(b.state() == State::kBrake);
  CHECK(b.fault() == Fault::kEncoder);
  CHECK(b.outputs.effort == AxisValues{});
  CHECK(b.device.fault_log().entry(0).axis == 5);
  b.rearm();
  CHECK(b.state() == State::kBrake);
  CHECK(b.read(number::kEncoderErrors + 5) == 3);
  b.inputs.encoder_errors = 0;
  b.rearm();
  CHECK(b.state() == State::kIdle);
  CHECK(b.fault() == Fault::kNone);
}

TEST_CASE("a device that requires homing refuses FORCE, reports why, and accepts it once homed in its cradle") {
  DeviceBench b = demanding_bench();
  b.start_force({1, 0, 0, 0, 0, 0});
  CHECK(b.state() == State::kIdle);
  CHECK(b.limited(Limit::kNotHomed));
  CHECK(b.outputs.effort == AxisValues{});
  REQUIRE(b.execute(number::kHome, 2) == ServiceStatus::kGood);
  b.command(State::kForce, {1, 0, 0, 0, 0, 0});
  CHECK(b.state() == State::kForce);
  CHECK_FALSE(b.limited(Limit::kNotHomed));
  CHECK(b.frame.counts == AxisCounts{1000, 2000, 3000, 4000, 5000, 6000});
  CHECK(b.read(number::kHomingState) == 2);
  CHECK(b.read(number::kHomedAxes) == 63);
}

TEST_CASE("homing by index leaves the motors free, refuses FORCE until the last axis is through, and shows how far") {
  DeviceBench b = demanding_bench();
  b.command(State::kIdle);
  b.command(State::kIdle);
  REQUIRE(b.execute(number::kHome, 1) == ServiceStatus::kGood);
  CHECK(b.read(number::kHomingState) == 1);
  for (unsigned k = 0; k < kAxes; ++k) {
    b.command(State::kForce, {1, 1, 1, 0, 0, 0});
    CHECK(b.state() == State::kIdle);
    CHECK_FALSE(b.outputs.brake);
    CHECK(b.limited(Limit::kHoming));
    CHECK(b.write(number::kMaxForce, 1.0f) == ServiceStatus::kBusy);
    b.inputs.index_edges = static_cast<std::uint8_t>(1u << k);
    b.inputs.index_counts[k] = 50;
    b.command(State::kIdle);
    CHECK(b.read(number::kHomedAxes) == (2u << k) - 1);
  }
  CHECK_FALSE(b.limited(Limit::kHoming));
  b.command(State::kForce);
  CHECK(b.state() == State::kForce);
}

TEST_CASE("a homing that the configuration does not demand refuses FORCE as well, while it lasts") {
  DeviceConfig config = bench_config();
  config.encoders = indexed();
  DeviceBench b(config);
  b.command(State::kIdle);
  b.command(State::kIdle);
  REQUIRE(b.execute(number::kHome, 1) == ServiceStatus::kGood);
  b.command(State::kForce);
  CHECK(b.state() == State::kIdle);
  CHECK(b.limited(Limit::kHoming));
  CHECK_FALSE(b.limited(Limit::kNotHomed));
  REQUIRE(b.execute(number::kHome, 0) == ServiceStatus::kGood);
  b.command(State::kForce);
  CHECK(b.state() == State::kForce);
}

TEST_CASE("a homing may be given up") {
  DeviceBench b = demanding_bench();
  b.command(State::kIdle);
  b.command(State::kIdle);
  REQUIRE(b.execute(number::kHome, 1) == ServiceStatus::kGood);
  REQUIRE(b.execute(number::kHome, 0) == ServiceStatus::kGood);
  b.command(State::kForce);
  CHECK(b.state() == State::kIdle);
  CHECK(b.limited(Limit::kNotHomed));
  CHECK_FALSE(b.limited(Limit::kHoming));
}

TEST_CASE("a count that gets a new meaning is no overspeed, a real one in the same period is") {
  for (const bool too_fast : {false, true}) {
    DeviceBench b = demanding_bench();
    b.inputs.counts = {500000, -500000, 1, 2, 3, 4};
    b.command(State::kIdle);
    b.command(State::kIdle);
    REQUIRE(b.execute(number::kHome, 2) == ServiceStatus::kGood);
    if (too_fast) b.inputs.counts[1] += 300;  // 3 m/s, of 2
    b.command(State::kIdle);
    CHECK((b.state() == State::kBrake) == too_fast);
    CHECK(b.fault() == (too_fast ? Fault::kOverspeed : Fault::kNone));
  }
}

TEST_CASE("after an encoder fault a device that demands homing has to be homed again") {
  DeviceBench b = demanding_bench();
  b.command(State::kIdle);
  b.command(State::kIdle);
  REQUIRE(b.execute(number::kHome, 2) == ServiceStatus::kGood);
  b.command(State::kForce);
  REQUIRE(b.state() == State::kForce);
  b.inputs.encoder_errors = 1;
  b.command(State::kForce);
  b.inputs.encoder_errors = 0;
  b.rearm();
  b.command(State::kForce);
  CHECK(b.state() == State::kIdle);
  CHECK(b.limited(Limit::kNotHomed));
  CHECK(b.read(number::kHomedAxes) == 62);
  REQUIRE(b.execute(number::kHome, 2) == ServiceStatus::kGood);
  b.command(State::kForce);
  CHECK(b.state() == State::kForce);
}

TEST_CASE("a new encoder configuration takes the homing away, any other write leaves it") {
  DeviceBench b = demanding_bench();
  b.command(State::kIdle);
  b.command(State::kIdle);
  REQUIRE(b.execute(number::kHome, 2) == ServiceStatus::kGood);
  REQUIRE(b.write(number::kMaxForce, 5.0f) == ServiceStatus::kGood);
  b.command(State::kIdle);
  CHECK(b.read(number::kHomingState) == 2);
  REQUIRE(b.write(number::kDirection, -1) == ServiceStatus::kGood);
  b.command(State::kIdle);
  CHECK(b.read(number::kHomingState) == 0);
}
