// A device that has just started, or was reset in mid-run: no force before its host has wanted IDLE.
#include <random>

#include "tests/firmware/device_bench.h"

using namespace tactus::firmware;

TEST_CASE(
    "a device that has just started applies no force before a command requests IDLE, whatever other commands arrive") {
  std::mt19937_64 random(11);
  for (int run = 0; run < 200; ++run) {
    DeviceBench b;
    b.sequence = static_cast<std::uint32_t>(random());  // that of a host in mid-run
    for (int i = 0; i < 60; ++i) {
      if (random() % 8 == 0) b.nothing(static_cast<int>(random() % 15) + 1);
      b.command(random() % 8 == 0 ? State::kBrake : State::kForce, {9, 0, 0, 0, 0, 0}, random() % 2 == 0);
      REQUIRE(b.state() != State::kForce);
      REQUIRE(b.outputs.effort == AxisValues{});
      REQUIRE(b.limited(Limit::kIdleFirst));
    }
  }
}

TEST_CASE("after a command that requests IDLE, even the one that starts the sequence, the next one can request FORCE") {
  const bool starts = GENERATE(true, false);
  DeviceBench b;
  if (!starts) {
    b.command(State::kForce, {9});
    b.command(State::kForce, {9});
  }
  b.command(State::kIdle, {9});
  CHECK(b.state() == State::kIdle);
  CHECK_FALSE(b.limited(Limit::kIdleFirst));
  b.command(State::kForce, {9});
  CHECK(b.state() == State::kForce);
  CHECK(b.outputs.effort[0] == 9.0f);
  // Once is enough: from here on the latch decides.
  b.nothing(20);
  REQUIRE(b.state() == State::kBrake);
  b.command(State::kForce);
  b.command(State::kForce);
  b.command(State::kForce, {}, true);
  b.command(State::kForce, {9});
  CHECK(b.state() == State::kForce);
}

TEST_CASE("an IDLE that is stale or broken does not count") {
  DeviceBench b;
  b.sequence = 5;
  b.command(State::kForce, {9});
  std::array<std::byte, kCommandFrameSize> bytes{};
  encode_command({State::kIdle, false, 5, {}}, bytes);
  b.step(bytes);
  encode_command({State::kIdle, false, 8, {}}, bytes);
  bytes[12] ^= std::byte{1};
  b.step(bytes);
  CHECK(b.limited(Limit::kIdleFirst));
  b.command(State::kForce, {9});
  CHECK(b.state() == State::kIdle);
}

TEST_CASE("a device that braked before its first IDLE reaches FORCE by a re-arm that requests IDLE") {
  DeviceBench b;
  b.command(State::kForce, {9});
  b.command(State::kBrake);
  REQUIRE(b.state() == State::kBrake);
  b.command(State::kForce, {9}, true);
  CHECK(b.state() == State::kIdle);
  b.command(State::kForce, {9});
  CHECK(b.state() == State::kIdle);
  b.command(State::kBrake);
  b.command(State::kIdle, {}, true);
  b.command(State::kForce, {9});
  CHECK(b.state() == State::kForce);
}
