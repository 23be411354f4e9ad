// The host's end against firmware/conformance.txt: what it says goes out as the bytes there, what comes in says the
// same.
#include <fstream>
#include <sstream>

#include "hal/frame_codec.h"
#include "hal/kinematics/kinematics.h"
#include "tests/support/conformance.h"

#include <catch2/catch.hpp>

using namespace tactus;
using namespace tactus::hal;

namespace {

const AxisVector kQuantum{1e-5, 1e-5, 1e-5, 1e-4, 1e-4, 1e-4};

// An arm whose axes are the tool's, the rotations in the order z, y, x: a wrench is its efforts.
FrameCodec codec() { return {CartesianStage(), kQuantum, true}; }

// "wants FORCE, re-arm 0, sequence 42, efforts 1.5 0 -2.25 0 0 0.125"
haptics::DeviceCommand command_of(const std::string& line) {
  char state[16] = "";
  unsigned rearm = 0;
  unsigned long long sequence = 0;
  haptics::DeviceCommand command;
  Vec3d& f = command.wrench.force;
  Vec3d& t = command.wrench.torque;
  REQUIRE(std::sscanf(line.c_str(), "wants %15[A-Z], re-arm %u, sequence %llu, efforts %lf %lf %lf %lf %lf %lf", state,
                      &rearm, &sequence, &f.x, &f.y, &f.z, &t.z, &t.y, &t.x) == 9);
  const std::string name = state;
  command.wanted = name == "IDLE"    ? haptics::DeviceState::kIdle
                   : name == "FORCE" ? haptics::DeviceState::kForce
                                     : haptics::DeviceState::kBrake;
  command.rearm = rearm;
  command.sequence = sequence;
  return command;
}

std::string says(const haptics::DeviceSample& s) {
  firmware::StateFrame frame;
  frame.state = static_cast<firmware::State>(s.state);
  frame.sequence = static_cast<std::uint32_t>(s.sequence);
  frame.time_us = s.device_time_ns / 1000;
  frame.fault = static_cast<std::uint16_t>(s.device_fault);
  frame.limits = static_cast<std::uint16_t>(s.limits);
  frame.buttons = static_cast<std::uint8_t>(s.buttons);
  frame.missed_commands = static_cast<std::uint8_t>(s.missed_commands);
  frame.echoed_sequence = static_cast<std::uint32_t>(s.echoed_sequence);
  return test::says(frame);
}

}  // namespace

TEST_CASE("the host's codec encodes and decodes the frames of the conformance file") {
  std::ifstream file(TACTUS_SOURCE_DIR "/firmware/conformance.txt");
  REQUIRE(file.good());
  std::string line, wants, out;
  unsigned sent = 0, heard = 0;
  while (std::getline(file, line)) {
    const std::string word = line.substr(0, line.find(' ')), rest = line.substr(std::min(line.size(), word.size() + 1));
    if (word == "in" && !wants.empty()) {
      std::array<std::byte, firmware::kCommandFrameSize> bytes{};
      codec().encode(command_of(wants), bytes);
      CAPTURE(wants);
      CHECK(test::hex_of(bytes) == rest);
      ++sent;
    }
    if (word == "says") {
      haptics::DeviceSample sample;
      CAPTURE(line);
      REQUIRE(codec().decode(test::bytes_of(out), sample) == firmware::DecodeError::kNone);
      CHECK(says(sample) == rest);
      ++heard;
    }
    wants = word == "wants" ? line : "";
    if (word == "out") out = rest;
  }
  CHECK(sent > 100);
  CHECK(heard > 100);
}
