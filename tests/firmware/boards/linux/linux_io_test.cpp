// The kernel's files by a folder of plain ones.
#include "firmware/boards/linux/linux_io.h"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>

using namespace tactus::firmware;

namespace {

namespace fs = std::filesystem;

// Counter, PWM and direction of axes 0 and 3, and the three lines.
class FakeBoard {
 public:
  FakeBoard() {
    root_ = fs::temp_directory_path() / ("tactus_linux_io_" + std::to_string(getpid()));
    fs::remove_all(root_);
    for (const char* axis : {"0", "3"}) {
      fs::create_directories(root_ / ("pwm" + std::string(axis)));
      set("count" + std::string(axis), "0\n");
      set("direction" + std::string(axis), "0\n");
      for (const char* file : {"period", "duty_cycle", "enable"}) set("pwm" + std::string(axis) + "/" + file, "0\n");
    }
    set("stop", "0\n");
    set("bus", "1\n");
    set("brake", "0\n");
    description_.pwm_period_ns = 50'000;
    description_.stop_line.path = path("stop");
    description_.motor_bus.path = path("bus");
    description_.brake_line.path = path("brake");
    for (const unsigned axis : {0u, 3u}) {
      const std::string number = std::to_string(axis);
      description_.axes[axis] = {path("count" + number), path("pwm" + number), path("direction" + number), 32, 10.0f};
    }
  }
  ~FakeBoard() { fs::remove_all(root_); }

  std::string path(const std::string& name) const { return (root_ / name).string(); }
  // In place, as the kernel's file stays the same file.
  void set(const std::string& name, const std::string& text) const {
    std::ofstream(root_ / name, std::ios::trunc) << text;
  }
  std::string get(const std::string& name) const {
    std::string text;
    std::ifstream(root_ / name) >> text;
    return text;
  }
  MechanicsDescription& description() { return description_; }

 private:
  fs::path root_;
  MechanicsDescription description_;
};

ControllerInputs sample(LinuxMechanics& mechanics) {
  ControllerInputs inputs;
  mechanics.sample(inputs);
  return inputs;
}

ControllerOutputs efforts(float axis0, float axis3) {
  ControllerOutputs outputs;
  outputs.brake = false;
  outputs.effort[0] = axis0;
  outputs.effort[3] = axis3;
  return outputs;
}

}  // namespace

TEST_CASE("Linux board: after opening, the PWM runs at zero duty and the motors are shorted", "[firmware]") {
  FakeBoard board;
  board.set("pwm0/duty_cycle", "7777\n");
  LinuxMechanics mechanics;
  REQUIRE(mechanics.open(board.description()) == "");
  CHECK(board.get("pwm0/period") == "50000");
  CHECK(board.get("pwm0/duty_cycle")[0] == '0');
  CHECK(board.get("pwm0/enable") == "1");
  CHECK(board.get("brake") == "1");
}

TEST_CASE("Linux board: counts, e-stop and supply are what the files say", "[firmware]") {
  FakeBoard board;
  LinuxMechanics mechanics;
  REQUIRE(mechanics.open(board.description()) == "");
  board.set("count0", "1234\n");
  board.set("count3", "-56\n");
  ControllerInputs inputs = sample(mechanics);
  CHECK(inputs.counts == AxisCounts{1234, 0, 0, -56, 0, 0});
  CHECK_FALSE(inputs.emergency_stop);
  CHECK(inputs.motor_bus_ok);
  board.set("stop", "1\n");
  board.set("bus", "0\n");
  inputs = sample(mechanics);
  CHECK(inputs.emergency_stop);
  CHECK_FALSE(inputs.motor_bus_ok);
  CHECK(mechanics.failures() == 0);
}

TEST_CASE("Linux board: a counter of any width counts on over its wrap", "[firmware]") {
  std::mt19937_64 random(11);
  for (const unsigned bits : {8u, 16u, 24u, 32u, 48u, 64u}) {
    FakeBoard board;
    board.description().axes[0].count_bits = bits;
    LinuxMechanics mechanics;
    REQUIRE(mechanics.open(board.description()) == "");
    const std::uint64_t mask = bits == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << bits) - 1;
    std::int64_t position = 0;
    for (int i = 0; i < 40; ++i) {
      // Less than half the range of the narrowest, and the sum stays inside 32 bits.
      position += static_cast<std::int64_t>(random() % 255) - 127;
      board.set("count0", std::to_string(static_cast<std::uint64_t>(position) & mask) + "\n");
      REQUIRE(sample(mechanics).counts[0] == position);
    }
  }
}

TEST_CASE("Linux board: the duty is the effort's share of full duty, its sign is the direction", "[firmware]") {
  FakeBoard board;
  LinuxMechanics mechanics;
  REQUIRE(mechanics.open(board.description()) == "");
  std::mt19937 random(12);
  std::uniform_real_distribution<float> any(-12.0f, 12.0f);
  for (int i = 0; i < 50; ++i) {
    const float effort = any(random);
    mechanics.drive(efforts(effort, -effort));
    const double share = std::min(std::abs(static_cast<double>(effort)) / 10.0, 1.0);
    CHECK(std::stod(board.get("pwm0/duty_cycle")) == Approx(share * 50'000).margin(1.0));
    CHECK(board.get("direction0") == (effort < 0 ? "1" : "0"));
    CHECK(board.get("direction3") == (effort < 0 ? "0" : "1"));
    CHECK(board.get("brake") == "0");
  }
}

TEST_CASE("Linux board: braking takes the duty away and shorts the motors, whatever the effort says", "[firmware]") {
  FakeBoard board;
  LinuxMechanics mechanics;
  REQUIRE(mechanics.open(board.description()) == "");
  mechanics.drive(efforts(5, 5));
  ControllerOutputs outputs = efforts(5, 5);
  outputs.brake = true;
  mechanics.drive(outputs);
  CHECK(std::stoi(board.get("pwm0/duty_cycle")) == 0);
  CHECK(std::stoi(board.get("pwm3/duty_cycle")) == 0);
  CHECK(board.get("brake") == "1");
}

TEST_CASE("Linux board: an effort that is no number gives no duty", "[firmware]") {
  FakeBoard board;
  LinuxMechanics mechanics;
  REQUIRE(mechanics.open(board.description()) == "");
  mechanics.drive(efforts(5, 5));
  mechanics.drive(efforts(std::nanf(""), -std::nanf("")));
  CHECK(std::stoi(board.get("pwm0/duty_cycle")) == 0);
  CHECK(std::stoi(board.get("pwm3/duty_cycle")) == 0);
}

TEST_CASE("Linux board: what cannot be read counts as a bad motor supply in the same period", "[firmware]") {
  for (const char* file : {"count0", "stop", "bus"}) {
    FakeBoard board;
    LinuxMechanics mechanics;
    REQUIRE(mechanics.open(board.description()) == "");
    board.set("count0", "5\n");
    CHECK(sample(mechanics).motor_bus_ok);
    board.set(file, "");
    const ControllerInputs inputs = sample(mechanics);
    CHECK_FALSE(inputs.motor_bus_ok);
    CHECK(inputs.counts[0] == 5);  // where it was last seen
    CHECK(inputs.encoder_errors == (std::string(file) == "count0" ? 1 : 0));
    CHECK(mechanics.failures() == 1);
    board.set(file, "1\n");
    CHECK(sample(mechanics).motor_bus_ok);
  }
}

TEST_CASE("Linux board: a motor that takes no value counts as a bad supply in the next period", "[firmware]") {
  FakeBoard board;
  board.description().axes[0].pwm = board.path("pwm0");
  fs::remove(board.path("pwm0/duty_cycle"));
  fs::create_symlink("/dev/full", board.path("pwm0/duty_cycle"));
  LinuxMechanics mechanics;
  CHECK(mechanics.open(board.description()).find("takes no period") != std::string::npos);

  FakeBoard other;
  fs::remove(other.path("brake"));
  fs::create_symlink("/dev/full", other.path("brake"));
  other.description().brake_line.active = '1';
  CHECK(mechanics.open(other.description()).find("motors do not take a value") != std::string::npos);
  sample(mechanics);
  CHECK(sample(mechanics).motor_bus_ok);
  mechanics.drive(efforts(1, 0));
  CHECK_FALSE(sample(mechanics).motor_bus_ok);
}

TEST_CASE("Linux board: a file that is not there is named when opening", "[firmware]") {
  for (const char* file : {"count0", "stop", "direction3", "pwm3/period"}) {
    FakeBoard board;
    fs::remove(board.path(file));
    LinuxMechanics mechanics;
    CHECK(mechanics.open(board.description()).find(file) != std::string::npos);
  }
}
