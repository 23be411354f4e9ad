// Commands on classic CAN; states and what both have in common: can_codec_test.cpp.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "firmware/can_codec.h"

using namespace tactus::firmware;

namespace {

CommandFrame command_of(std::uint32_t sequence, const std::array<float, kAxes>& effort) {
  CommandFrame command;
  command.wanted = State::kForce;
  command.sequence = sequence;
  command.effort = effort;
  return command;
}

CommandFrame carried(const CommandFrame& command) {
  CommandAssembler assembler;
  CommandFrame out;
  const auto fragments = split_command(command);
  REQUIRE_FALSE(assembler.accept(fragments[0].function, fragments[0].data, out));
  REQUIRE(assembler.accept(fragments[1].function, fragments[1].data, out));
  return out;
}

}  // namespace

TEST_CASE("efforts keep a relative error of 2^-15 of the largest of their three, at every size") {
  std::mt19937_64 random(51);
  std::uniform_real_distribution<float> share(-1.0f, 1.0f);
  for (unsigned i = 0; i < 50000; ++i) {
    const float size = std::ldexp(1.0f, static_cast<int>(random() % 24) - 14);  // 61 u to 512
    std::array<float, kAxes> effort{};
    for (unsigned a = 0; a < kAxes; ++a) effort[a] = share(random) * size * (a < 3 ? 1.0f : 0.125f);
    const CommandFrame out = carried(command_of(i, effort));
    for (unsigned group = 0; group < 2; ++group) {
      float largest = 0.0f;
      for (unsigned a = 3 * group; a < 3 * group + 3; ++a) largest = std::max(largest, std::abs(effort[a]));
      // Half a unit; the unit is at most largest / 16383.5, or the smallest there is.
      const float bound = 0.5f * std::max(largest / 16383.0f, std::ldexp(1.0f, -20));
      for (unsigned a = 3 * group; a < 3 * group + 3; ++a) REQUIRE(std::abs(out.effort[a] - effort[a]) <= bound);
    }
  }
}

TEST_CASE("what is not finite stays not finite, and what is too large shrinks without turning") {
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  CommandFrame out = carried(command_of(1, {nan, 2.0f, -1.0f, -infinity, infinity, 0.0f}));
  CHECK((!std::isfinite(out.effort[0]) && out.effort[1] == 2.0f && out.effort[2] == -1.0f));
  CHECK((!std::isfinite(out.effort[3]) && !std::isfinite(out.effort[4]) && out.effort[5] == 0.0f));

  out = carried(command_of(1, {4000.0f, -2000.0f, 1000.0f, 3.0e38f, 0.0f, -3.0e38f}));
  const float most = 32767.0f / 32.0f;
  CHECK(out.effort[0] == most);
  CHECK(out.effort[1] == Approx(-most / 2).margin(1.0 / 32));
  CHECK(out.effort[2] == Approx(most / 4).margin(1.0 / 32));
  CHECK((out.effort[3] == most && out.effort[4] == 0.0f && out.effort[5] == -most));
}

TEST_CASE("commands arrive with state, re-arm and a sequence that goes on over the wrap of its twelve bits") {
  CommandAssembler assembler;
  CommandFrame out;
  std::mt19937_64 random(61);
  std::uint32_t offset = 0;
  for (std::uint32_t i = 0; i < 10000; ++i) {
    CommandFrame command = command_of(77 + i, {});
    command.wanted = static_cast<State>(1 + random() % 3);
    command.rearm = random() % 2 == 0;
    assembler.look();
    bool whole = false;
    for (const CanFragment& fragment : split_command(command))
      whole = assembler.accept(fragment.function, fragment.data, out);
    REQUIRE(whole);
    REQUIRE((out.wanted == command.wanted && out.rearm == command.rearm));
    if (i == 0) offset = out.sequence - command.sequence;
    REQUIRE(out.sequence == command.sequence + offset);
  }
  // One sent again is old.
  const std::uint32_t newest = out.sequence;
  bool whole = false;
  for (const CanFragment& fragment : split_command(command_of(77 + 8000, {})))
    whole = assembler.accept(fragment.function, fragment.data, out);
  REQUIRE(whole);
  CHECK(out.sequence == newest - 1999);
}

TEST_CASE("half a command is no command, and halves of two are none either") {
  CommandAssembler assembler;
  CommandFrame out;
  const auto first = split_command(command_of(10, {1, 1, 1, 1, 1, 1}));
  const auto second = split_command(command_of(11, {2, 2, 2, 2, 2, 2}));
  CHECK_FALSE(assembler.accept(first[0].function, first[0].data, out));
  CHECK_FALSE(assembler.accept(second[1].function, second[1].data, out));
  CHECK(assembler.incomplete() == 1);
  CHECK(assembler.accept(second[0].function, second[0].data, out));
  CHECK(out.effort[0] == 2.0f);
  CHECK(assembler.incomplete() == 1);
}
