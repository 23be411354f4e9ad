#include "hal/frame_codec.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "hal/profiles.h"
#include "hal/simulated_link.h"

using namespace tactus;
using namespace tactus::hal;

namespace {

constexpr AxisVector kQuantum{1e-5, 1e-5, 1e-5, 1e-4, 1e-4, 1e-4};

std::array<std::byte, firmware::kStateFrameSize> state_bytes(const firmware::StateFrame& frame) {
  std::array<std::byte, firmware::kStateFrameSize> bytes{};
  firmware::encode_state(frame, bytes);
  return bytes;
}

std::uint64_t sequence_after(FrameCodec& codec, std::uint32_t wire) {
  firmware::StateFrame frame;
  frame.sequence = wire;
  haptics::DeviceSample sample;
  REQUIRE(codec.decode(state_bytes(frame), sample) == firmware::DecodeError::kNone);
  return sample.sequence;
}

firmware::CommandFrame sent(FrameCodec& codec, const haptics::DeviceCommand& command) {
  std::array<std::byte, firmware::kCommandFrameSize> bytes{};
  codec.encode(command, bytes);
  firmware::CommandFrame frame;
  REQUIRE(firmware::decode_command(bytes, frame) == firmware::DecodeError::kNone);
  return frame;
}

}  // namespace

TEST_CASE("sequences go on beyond 32 bits, and an old frame stays old") {
  FrameCodec codec(CartesianStage(), kQuantum, true);
  CHECK(sequence_after(codec, 0xfffffffeu) == 0xfffffffeull);
  CHECK(sequence_after(codec, 0xffffffffu) == 0xffffffffull);
  CHECK(sequence_after(codec, 1) == 0x1'0000'0001ull);
  CHECK(sequence_after(codec, 0xffffffffu) == 0xffffffffull);
  CHECK(sequence_after(codec, 2) == 0x1'0000'0002ull);
  FrameCodec early(CartesianStage(), kQuantum, true);
  CHECK(sequence_after(early, 5) == 5);
  CHECK(sequence_after(early, 3) == 3);
  CHECK(sequence_after(early, 0xfffffff0u) == 0xfffffff0ull);  // before the first: nothing to continue
}

TEST_CASE("a state frame becomes a sample in SI") {
  FrameCodec codec(CartesianStage(), kQuantum, true);
  static_cast<void>(sent(codec, {0x2'0000'0007ull, {}, haptics::DeviceState::kForce, 0}));
  firmware::StateFrame frame{.state = firmware::State::kForce,
                             .buttons = 5,
                             .missed_commands = 0,
                             .fault = 3,
                             .limits = 0x81,
                             .sequence = 9,
                             .echoed_sequence = 6,
                             .time_us = 123456,
                             .counts = {1000, -2000, 3, 100, 200, -300}};
  haptics::DeviceSample s;
  REQUIRE(codec.decode(state_bytes(frame), s) == firmware::DecodeError::kNone);
  CHECK(s.state == haptics::DeviceState::kForce);
  CHECK((s.buttons == 5 && s.device_fault == 3 && s.limits == 0x81 && s.sequence == 9));
  CHECK(s.echoed_sequence == 0x2'0000'0006ull);
  CHECK(s.device_time_ns == 123456000);
  const Posed pose = CartesianStage().pose_of({0.01, -0.02, 3e-5, 0.01, 0.02, -0.03});
  CHECK(norm(s.device_from_tool.position - pose.position) < 1e-16);
  CHECK(norm(small_rotation_vector(s.device_from_tool.rotation * conjugate(pose.rotation))) < 1e-15);
}

TEST_CASE("bytes that are no frame leave the sample alone") {
  FrameCodec codec(CartesianStage(), kQuantum, true);
  haptics::DeviceSample s;
  s.sequence = 42;
  auto bytes = state_bytes({});
  bytes[30] ^= std::byte{1};
  CHECK(codec.decode(bytes, s) == firmware::DecodeError::kWrongCrc);
  CHECK(s.sequence == 42);
}

TEST_CASE("a wrench becomes the efforts of the axes as they are") {
  FrameCodec codec(CartesianStage(), kQuantum, true);
  firmware::StateFrame frame;
  frame.counts = {0, 0, 0, 5000, -8000, 2000};  // 0.5, -0.8, 0.2 rad
  haptics::DeviceSample s;
  REQUIRE(codec.decode(state_bytes(frame), s) == firmware::DecodeError::kNone);
  const Wrenchd wrench{{1, 2, 3}, {0.4, 0.5, 0.6}};
  const auto out = sent(codec, {77, wrench, haptics::DeviceState::kForce, 1});
  const AxisVector effort = CartesianStage().efforts_of({0, 0, 0, 0.5, -0.8, 0.2}, wrench);
  for (unsigned i = 0; i < kAxisCount; ++i)
    CHECK(static_cast<double>(out.effort[i]) == Approx(effort[i]).epsilon(1e-6));
  CHECK((out.sequence == 77 && out.rearm && out.wanted == firmware::State::kForce));
}

TEST_CASE("without rotation no torque is sent, and wanting a reset is wanting to idle") {
  FrameCodec codec(CartesianStage(), kQuantum, false);
  const auto out = sent(codec, {1, {{1, 2, 3}, {4, 5, 6}}, haptics::DeviceState::kReset, 0});
  CHECK(out.effort == std::array<float, 6>{1, 2, 3, 0, 0, 0});
  CHECK(out.wanted == firmware::State::kIdle);
}

TEST_CASE("an arm's counts are joint angles, and its efforts are torques") {
  const WristedArm arm({0.45, 0.4});
  FrameCodec codec(arm, {2e-5, 2e-5, 2e-5, 1e-4, 1e-4, 1e-4}, true);
  firmware::StateFrame frame;
  frame.counts = {10000, -15000, 5000, 5000, -8000, 2000};
  const AxisVector q{0.2, -0.3, 0.1, 0.5, -0.8, 0.2};
  haptics::DeviceSample s;
  REQUIRE(codec.decode(state_bytes(frame), s) == firmware::DecodeError::kNone);
  CHECK(norm(s.device_from_tool.position - arm.pose_of(q).position) < 1e-15);
  CHECK(norm(small_rotation_vector(s.device_from_tool.rotation * conjugate(arm.pose_of(q).rotation))) < 1e-15);
  const Wrenchd wrench{{1, 2, 3}, {0.4, 0.5, 0.6}};
  const auto out = sent(codec, {1, wrench, haptics::DeviceState::kForce, 0});
  const AxisVector effort = arm.efforts_of(q, wrench);
  for (unsigned i = 0; i < kAxisCount; ++i)
    CHECK(static_cast<double>(out.effort[i]) == Approx(effort[i]).epsilon(1e-6));
}

TEST_CASE("whatever counts come, the pose is finite and so are the efforts of a finite wrench") {
  std::mt19937_64 random(5);
  for (const DeviceProfile& profile : all_profiles()) {
    FrameCodec codec(profile.kinematics, profile.quantum, profile.properties.has_rotation);
    for (int i = 0; i < 20000; ++i) {
      firmware::StateFrame frame;
      for (std::int32_t& count : frame.counts) count = static_cast<std::int32_t>(random());
      haptics::DeviceSample s;
      REQUIRE(codec.decode(state_bytes(frame), s) == firmware::DecodeError::kNone);
      REQUIRE(is_finite(s.device_from_tool));
      REQUIRE(norm(s.device_from_tool.rotation) == Approx(1.0).epsilon(1e-12));
      const auto out = sent(codec, {1, {{20, -20, 20}, {1, 2, 1}}, haptics::DeviceState::kForce, 0});
      for (const float effort : out.effort) REQUIRE(std::isfinite(effort));
    }
  }
}

TEST_CASE("a link delivers in the tick of arrival, once, and keeps the frame that was sent last") {
  SimulatedLink link;
  const std::array<std::byte, 2> old{std::byte{1}, std::byte{1}}, young{std::byte{2}, std::byte{2}};
  link.send(5, 8, old);
  CHECK(link.arriving(7).empty());
  CHECK(link.arriving(8).size() == 2);
  CHECK(link.arriving(9).empty());
  CHECK(link.arriving(8 + SimulatedLink::kMaxAhead + 1).empty());
  link.send(8, 8, young);
  CHECK(link.arriving(8)[0] == std::byte{2});
  link.send(6, 8, old);
  CHECK(link.arriving(8)[0] == std::byte{2});
  link.clear();
  CHECK(link.arriving(8).empty());
}
