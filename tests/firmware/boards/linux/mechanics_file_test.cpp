#include "firmware/boards/linux/mechanics_file.h"

#include <catch2/catch.hpp>

using namespace tactus::firmware;

namespace {

const std::string kGood =
    "# a desk device with one motor\n"
    "device_class = 1\n"
    "max_force_N = 10\n"
    "stop_line = /s\n"
    "stop_line_active = 0\n"
    "axis0.count = /c0   # the base\n"
    "axis0.quantum = 2.5e-5\n"
    "axis0.max_speed = 1.5\n"
    "axis0.pwm = /p0\n"
    "axis0.full_effort = 6\n"
    "axis0.max_effort = 5\n"
    "axis0.direction = /d0\n"
    "\n"
    "axis5.count = /c5\n"
    "axis5.count_bits = 16\n"
    "axis5.quantum = 0.001\n"
    "axis5.max_speed = 20\n";

std::string error_of(const std::string& text) {
  MechanicsDescription description;
  return parse_mechanics(text, "board", description);
}

}  // namespace

TEST_CASE("mechanics file: every value arrives, and what is not given is not there", "[firmware]") {
  MechanicsDescription d;
  REQUIRE(parse_mechanics(kGood, "board", d) == "");
  CHECK(d.device_class == MechanismClass::kDesk3);
  CHECK(d.control.max_force_N == 10.0f);
  CHECK(d.stop_line.path == "/s");
  CHECK(d.stop_line.active == '0');
  CHECK(d.motor_bus.path.empty());
  CHECK(d.axes[0].count == "/c0");
  CHECK(d.axes[0].pwm == "/p0");
  CHECK(d.axes[0].direction == "/d0");
  CHECK(d.axes[0].full_effort == 6.0f);
  CHECK(d.control.quantum[0] == 2.5e-5f);
  CHECK(d.control.max_effort[0] == 5.0f);
  CHECK(d.control.max_speed[0] == 1.5f);
  CHECK(d.axes[5].count_bits == 16);
  CHECK(d.control.max_effort[5] == 0.0f);
  CHECK(d.axes[1].count.empty());
  CHECK(is_valid(d.control));  // axes that are not there included
}

TEST_CASE("mechanics file: a line that is wrong is named with its number and what is accepted", "[firmware]") {
  CHECK(error_of("max_force_N 10\n") == "board:1: 'max_force_N 10'; accepted: key = value");
  CHECK(error_of("\nmax_force = 10\n").find("board:2: unknown key 'max_force'") == 0);
  CHECK(error_of("max_force_N = ten\n").find("board:1: max_force_N = 'ten'; accepted: a number from 0") == 0);
  CHECK(error_of("max_force_N = -1\n").find("a number from 0 to") != std::string::npos);
  CHECK(error_of("max_force_N = nan\n").find("accepted: a number") != std::string::npos);
  CHECK(error_of("max_force_N = 1 N\n").find("accepted: a number") != std::string::npos);
  CHECK(error_of("axis0.count_bits = 16.5\n").find("a whole number from 8 to 64") != std::string::npos);
  CHECK(error_of("axis6.quantum = 1\n").find("unknown key") != std::string::npos);
  CHECK(error_of("axis0.count = counter0\n").find("a path from /") != std::string::npos);
  CHECK(error_of("stop_line_active = high\n").find("0 or 1") != std::string::npos);
  CHECK(error_of("max_force_N = 1\nmax_force_N = 1\n") == "board:2: max_force_N stands twice");
}

TEST_CASE("mechanics file: half an axis is refused", "[firmware]") {
  const auto without = [](const std::string& key) {
    const auto begin = kGood.find(key);
    return kGood.substr(0, begin) + kGood.substr(kGood.find('\n', begin) + 1);
  };
  CHECK(error_of(kGood).empty());
  CHECK(error_of("").find("no axis has a counter") != std::string::npos);
  for (const char* key : {"axis0.quantum", "axis0.max_speed", "axis0.pwm", "axis0.max_effort", "axis0.full_effort",
                          "axis0.direction", "axis5.quantum", "axis5.max_speed"}) {
    INFO(key);
    CHECK_FALSE(error_of(without(key)).empty());
  }
}

TEST_CASE("mechanics file: the example is accepted as it is", "[firmware]") {
  MechanicsDescription d;
  REQUIRE(read_mechanics(TACTUS_SOURCE_DIR "/firmware/boards/linux/example_mechanics.txt", d) == "");
  CHECK(d.axes[3].count_bits == 16);
  CHECK(is_valid(d.control));
  CHECK(read_mechanics("/no-such-file", d) == "/no-such-file: cannot be read");
  CHECK(read_mechanics("/", d) == "/: cannot be read");
}
