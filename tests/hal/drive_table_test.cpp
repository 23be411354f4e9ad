// Reading an arm of drives from a device file: the shipped ones, and each mistake at its place.
#include "hal/drive_table.h"

#include <catch2/catch.hpp>
#include <fstream>
#include <sstream>

#include "hal/device_file.h"
#include "hal/drives/bus_load.h"
#include "hal/drives/drive_check.h"

using namespace tactus;
using namespace tactus::hal;
using Catch::Matchers::Contains;

namespace {

std::string shipped(const std::string& name) {
  std::ifstream file(TACTUS_SOURCE_DIR "/hal/devices/" + name + ".toml");
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

std::string spoilt(const std::string& name, const std::string& from, const std::string& to) {
  std::string text = shipped(name);
  const std::size_t at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

DeviceDescription described(const std::string& text) {
  const auto read = parse_device_description(text, "my.toml");
  INFO(read.message());
  REQUIRE(read.ok());
  return read.value();
}

}  // namespace

TEST_CASE("the shipped arms of drives are read, fit their buses at 1 kHz, and have the quantum of their frames") {
  const DeviceDescription point = described(shipped("point_arm_drives"));
  REQUIRE(point.drives.axes.size() == 3);
  CHECK(point.drives.family == DriveFamily::kDamiao);
  CHECK(point.drives.buses == std::vector<std::string>{"can0"});
  CHECK((point.drives.axes[2].id == 3 && point.drives.axes[2].answer_id == 19));
  CHECK((point.drives.axes[1].torque_range_Nm == 5 && point.drives.axes[1].damping_Nms_per_rad == 0.04));
  CHECK((point.drives.watchdog_s == 0.01 && point.drives.full_effort_s == 0.004));
  // 65535 steps over 6.4 rad.
  CHECK(point.counts_per_turn[0] == Approx(65535 * 2 * 3.14159265358979 / 6.4));
  const DeviceDescription six = described(shipped("wristed_arm_moteus"));
  REQUIRE(six.drives.axes.size() == 6);
  CHECK((six.drives.axes[2].bus == 0 && six.drives.axes[3].bus == 1));
  CHECK(six.drives.data_bit_per_s == 5'000'000);
  CHECK(six.counts_per_turn[0] == 8 * 16384);
  for (const auto* one : {&point, &six}) {
    CHECK(check_bus_load(one->drives, std::chrono::milliseconds(1)).ok());
    const DeviceProfile profile = make_profile(*one);
    CHECK(profile.properties.damping_Ns_per_m > one->damping_Ns_per_m + 0.1);
    CHECK(profile.plant.damping_Ns_per_m == one->damping_Ns_per_m);
  }
}

TEST_CASE("each mistake of a drive has its axis, its key, what was found and what is accepted") {
  struct Case {
    const char *device, *from, *to, *where, *what, *accepted;
  };
  const Case cases[] = {
      {"point_arm_drives", "\"damiao\"", "\"damio\"", "[drives] family", "did you mean damiao?", "robstride"},
      {"point_arm_drives", "watchdog_ms = 10", "watchdog_ms = 25", "[drives] watchdog_ms", "25 ms", "at most 10"},
      {"point_arm_drives", "family = \"damiao\"\nbuses = [\"can0\"]\nwatchdog_ms = 10",
       "family = \"cubemars\"\nbuses = [\"can0\"]", "[drives] watchdog_ms", "missing", "maker's tool"},
      {"point_arm_drives", "buses = [\"can0\"]", "buses = [3]", "[drives] buses", "3 is not text", "can0"},
      {"point_arm_drives", "buses = [\"can0\"]", "buses = [\"\"]", "[drives] buses", "no CAN interface", "can0"},
      {"wristed_arm_moteus", "[\"can0\", \"can1\"]", "[\"can0\", \"can0\"]", "[drives] buses", "can0 twice", "can1"},
      {"point_arm_drives", "watchdog_ms = 10", "data_bit_per_s = 5000000", "[drives] data_bit_per_s", "classic CAN",
       "leave it out"},
      {"point_arm_drives", "id = 2\n", "id = 1\n", "[drives.axis.0] id", "that of axis 1", "one of its own"},
      {"point_arm_drives", "answer_id = 18", "answer_id = 17", "[drives.axis.0] answer_id", "meets axis 1", "above"},
      {"point_arm_drives", "id = 1\nanswer_id = 17", "id = 1\nanswer_id = 1", "[drives.axis.0] answer_id", "outrank",
       "above"},
      {"point_arm_drives", "torque_range_Nm = 5 ", "torque_range_Nm = 0.5 ", "[drives.axis.0] torque_range_Nm", "need",
       "a stronger drive"},
      {"point_arm_drives", "offset_rad = 0", "offset_rad = 2.5", "[drives.axis.0] position_range_rad",
       "3.2, but the drive turns to", "nine tenths"},
      {"point_arm_drives", "damping_Nms_per_rad = 0.04", "damping_Nms_per_rad = 6",
       "[drives.axis.0] damping_Nms_per_rad", "beyond the drive's range", "at most 5"},
      {"point_arm_drives", "speed_range_rad_per_s = 50 ", "counts_per_turn = 50 ",
       "[drives.axis.0] speed_range_rad_per_s", "missing", ">= 0.1"},
      {"point_arm_drives", "id = 1\n", "id = 1\nsign = 0.5\n", "[drives.axis.0] sign", "0.5", "1 or -1"},
      {"point_arm_drives", "id = 1\n", "id = 1\nsgn = -1\n", "[drives.axis.0] sgn", "did you mean sign?", "sign"},
      {"point_arm_drives", "[drives]", "[encoders]\n[drives]", "encoders", "", "drives"},
      {"wristed_arm_moteus", "bus = 0", "bus = 0\nposition_range_rad = 3", "[drives.axis.0] position_range_rad",
       "no such field", "leave it out"},
      {"wristed_arm_moteus", "id = 6", "id = 5", "[drives.axis.4] id", "that of axis 5", "one of its own"},
  };
  for (const Case& c : cases) {
    const auto read = parse_device_description(spoilt(c.device, c.from, c.to), "my.toml");
    INFO(c.to << ": " << read.message());
    REQUIRE_FALSE(read.ok());
    CHECK_THAT(read.message(), Contains("my.toml:") && Contains(c.where) && Contains(c.what) && Contains(c.accepted));
  }
  std::string two = shipped("point_arm_drives");
  two.erase(two.rfind("[[drives.axis]]"), two.rfind("[link]") - two.rfind("[[drives.axis]]"));
  CHECK_THAT(parse_device_description(two, "my.toml").message(), Contains("2 entries") && Contains("3, one for each"));
}

TEST_CASE("a drive's watchdog lasts five periods at least, and no advice is given that was followed") {
  DriveDescription drives = described(shipped("point_arm_drives")).drives;
  const auto message = [&](double watchdog_s, std::chrono::nanoseconds period) {
    drives.watchdog_s = watchdog_s;
    return check_watchdog(drives, period).message();
  };
  CHECK(message(0.005, std::chrono::milliseconds(1)).empty());
  CHECK_THAT(message(0.001, std::chrono::milliseconds(1)), Contains("watchdog_ms is 1,") &&
                                                               Contains("at least 5 periods") &&
                                                               Contains("watchdog_ms = 5 to 10, or --rate 5000 at"));
  // A period so long that no watchdog of 10 ms is enough.
  CHECK_THAT(message(0.01, std::chrono::milliseconds(5)), Contains("that is --rate 500 at least"));
  drives.family = DriveFamily::kRobStride;
  drives.buses = {"can0"};
  CHECK_THAT(check_bus_load(drives, std::chrono::milliseconds(1)).message(),
             Contains("or the drives spread over two buses"));
  drives = described(shipped("wristed_arm_moteus")).drives;
  drives.family = DriveFamily::kRobStride;
  const std::string full = check_bus_load(drives, std::chrono::milliseconds(1)).message();
  CHECK_THAT(full, Contains("96 %") && Contains("--rate 937 at most"));
  CHECK(full.find("two buses") == std::string::npos);
}

TEST_CASE("an ODrive closes no damping and none in the brake") {
  std::string text = shipped("wristed_arm_moteus");
  const auto replace_all = [&text](const std::string& from, const std::string& to) {
    for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
      text.replace(at, from.size(), to);
  };
  replace_all("\"moteus\"", "\"odrive\"");
  replace_all("data_bit_per_s = 5000000\n", "");
  CHECK_THAT(parse_device_description(text, "my.toml").message(), Contains("[drives.axis.0] damping_Nms_per_rad") &&
                                                                      Contains("odrive has no damping") &&
                                                                      Contains("leave it out"));
  replace_all("\ndamping_Nms_per_rad = 0.005", "");
  replace_all("\ndamping_Nms_per_rad = 0.0002", "");
  CHECK_THAT(parse_device_description(text, "my.toml").message(),
             Contains("brake_damping_Nms_per_rad") && Contains("odrive has no damping"));
}
