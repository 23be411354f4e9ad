#include "hal/device_file.h"

#include <catch2/catch.hpp>
#include <fstream>
#include <sstream>

#include "rt/haptics/coupling_limits.h"
#include "tests/support/temporary_file.h"

using namespace tactus;
using namespace tactus::hal;

namespace {

std::string shipped(const std::string& name) { return TACTUS_SOURCE_DIR "/hal/devices/" + name + ".toml"; }

std::string text_of(const std::string& path) {
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  REQUIRE(!text.str().empty());
  return text.str();
}

// A shipped file with `from` written otherwise.
std::string spoilt(const std::string& name, const std::string& from, const std::string& to) {
  std::string text = text_of(shipped(name));
  const std::size_t at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

std::string message(const std::string& text) {
  const auto device = parse_device_description(text, "my.toml");
  return device.ok() ? std::string() : device.message();
}

unsigned line_of(const std::string& text, const std::string& part) {
  const std::size_t at = text.find(part);
  REQUIRE(at != std::string::npos);
  return static_cast<unsigned>(std::count(text.begin(), text.begin() + static_cast<long>(at), '\n')) + 1;
}

}  // namespace

TEST_CASE("the shipped files describe exactly the built-in devices") {
  for (const hal::DeviceDescription& built_in : hal::built_in_descriptions()) {
    CAPTURE(built_in.name);
    const auto read = parse_device_description(text_of(shipped(built_in.name)), "shipped");
    INFO(read.message());
    REQUIRE(read.ok());
    CHECK(read.value() == built_in);
    const auto profile = load_device_file(shipped(built_in.name));
    REQUIRE(profile.ok());
    const hal::DeviceProfile& known = *hal::find_profile(built_in.name);
    CHECK(profile.value().quantum == known.quantum);
    CHECK(profile.value().plant.max_effort == known.plant.max_effort);
    CHECK(profile.value().properties.position_quantum_m == known.properties.position_quantum_m);
  }
}

TEST_CASE("every figure of a shipped file is read: another value is another device") {
  for (const hal::DeviceDescription& built_in : hal::built_in_descriptions()) {
    std::istringstream lines(text_of(shipped(built_in.name)));
    unsigned figures = 0;
    for (std::string line; std::getline(lines, line);) {
      const std::size_t equals = line.find(" = ");
      if (line.empty() || line[0] == '#' || equals == std::string::npos || line.find('"') != std::string::npos)
        continue;
      const std::string key = line.substr(0, equals);
      std::string changed = line;
      if (key == "transport_delay_ticks")
        changed = key + " = 2";
      else if (key == "counts_per_turn")
        changed.replace(changed.find('['), 2, "[7");
      else
        changed = key + " = " + std::to_string(0.9 * std::stod(line.substr(equals + 3)));
      const auto other = parse_device_description(spoilt(built_in.name, line, changed), "other");
      INFO(changed << "\n" << other.message());
      REQUIRE(other.ok());
      CHECK_FALSE(other.value() == built_in);
      ++figures;
    }
    CHECK(figures == (built_in.has_rotation() ? 19 : 12));
  }
}

TEST_CASE("a stage has counts per metre before those per turn, and a link may name its device") {
  std::string text = spoilt("virtuose6d", "\"wristed_arm\"", "\"stage\"");
  const auto replace = [&text](const std::string& from, const std::string& to) {
    REQUIRE(text.find(from) != std::string::npos);
    text.replace(text.find(from), from.size(), to);
  };
  replace("upper_arm_m = 0.45\n", "");
  replace("forearm_m = 0.45\n", "");
  replace("counts_per_turn = [262144, 262144, 262144, 65536, 65536, 65536]",
          "counts_per_m = [1e5, 2e5, 3e5]\ncounts_per_turn = [1000, 2000, 3000]");
  replace("[link]", "[link]\nusb_serial = \"A1-7\"\ncan_node = 9");
  const auto read = parse_device_description(text, "stage");
  INFO(read.message());
  REQUIRE(read.ok());
  CHECK(read.value().kind == hal::KinematicsKind::kStage);
  CHECK(read.value().counts_per_m == hal::AxisVector{1e5, 2e5, 3e5, 0, 0, 0});
  CHECK(read.value().counts_per_turn == hal::AxisVector{0, 0, 0, 1000, 2000, 3000});
  CHECK((read.value().usb_serial == "A1-7" && read.value().can_node == 9));
}

TEST_CASE("the simulated mechanics are the described ones, but for the figures of [plant]") {
  const auto described = parse_device_description(text_of(shipped("virtuose6d")), "described");
  REQUIRE(described.ok());
  const hal::PlantParameters same = hal::make_profile(described.value()).plant;
  CHECK((same.mass_kg == 0.3 && same.damping_Ns_per_m == 0.5 && same.stop_radius_m == 0.225));
  const auto read = parse_device_description(
      text_of(shipped("virtuose6d")) +
          "\n[plant]\nmass_kg = 0.5\ninertia_kg_m2 = 2e-3\ndamping_Ns_per_m = 0.1\n"
          "damping_Nms_per_rad = 1e-3\ncoulomb_friction_N = 0.6\ncoulomb_friction_Nm = 0.01\nstop_radius_m = 0.25\n",
      "other");
  INFO(read.message());
  REQUIRE(read.ok());
  const hal::DeviceProfile profile = hal::make_profile(read.value());
  CHECK((profile.plant.mass_kg == 0.5 && profile.plant.inertia_kg_m2 == 2e-3));
  CHECK((profile.plant.damping_Ns_per_m == 0.1 && profile.plant.damping_Nms_per_rad == 1e-3));
  CHECK((profile.plant.coulomb_force_N == 0.6 && profile.plant.coulomb_torque_Nm == 0.01));
  CHECK(profile.plant.stop_radius_m == 0.25);
  CHECK((profile.properties.mass_kg == 0.3 && profile.properties.damping_Ns_per_m == 0.5));
}

TEST_CASE("each mistake has its line, its key, what was found and what is accepted") {
  using Catch::Contains;
  struct Case {
    const char *device, *from, *to, *where, *what, *accepted;
  };
  const Case cases[] = {
      {"virtuose6d", "mass_kg = 0.3", "mass_kg = -1", "[mechanics] mass_kg", "-1 is not an apparent mass", ">= 0.001"},
      {"virtuose6d", "mass_kg = 0.3", "mass_kg = nan", "[mechanics] mass_kg", "is not an apparent mass", ">= 0.001"},
      {"virtuose6d", "mass_kg", "masss_kg", "[mechanics] masss_kg", "did you mean mass_kg?", "damping_Ns_per_m"},
      {"virtuose6d", "\"wristed_arm\"", "\"wristed_arms\"", "[kinematics] kind", "did you mean wristed_arm?", "stage"},
      {"virtuose6d", "forearm_m = 0.45", "forearm_m = 9", "[kinematics] forearm_m", "not the length of a link", "<= 5"},
      {"virtuose6d", "radius_m = 0.225", "radius_m = 0.4", "[workspace] radius_m", "more than the links reach",
       "at most 0.2"},
      {"virtuose6d", "continuous_force_N = 10", "continuous_force_N = 40", "[limits] continuous_force_N",
       "above the peak", "at most 35"},
      {"virtuose6d", "65536]", "65536, 1]", "[encoders] counts_per_turn", "7 entries", "at most 6"},
      {"virtuose6d", ", 65536]", "]", "[encoders] counts_per_turn", "5 entries for 6 axes", "6 numbers"},
      {"virtuose6d", "[262144,", "[0,", "[encoders] counts_per_turn", "0 is not a number of encoder counts",
       "one for each axis"},
      {"virtuose6d", "counts_per_turn", "counts_per_m = [1]\ncounts_per_turn", "[encoders] counts_per_m",
       "no prismatic axes", "counts_per_turn"},
      {"virtuose6d", "transport_delay_ticks = 1", "transport_delay_ticks = 0", "[link] transport_delay_ticks",
       "0 is not a delay", "from 1 to 32"},
      {"virtuose6d", "[link]", "[link]\ncan_node = 128", "[link] can_node", "128 is not a CAN node", "from 1 to 127"},
      {"desk3d", "mass_kg = 0.2", "mass_kg = 0.2\ninertia_kg_m2 = 1e-3", "[mechanics] inertia_kg_m2",
       "neither senses nor turns", "leave it out"},
      {"desk3d", "[link]", "[plant]\ninertia_kg_m2 = 1e-3\n[link]", "[plant] inertia_kg_m2", "neither senses nor turns",
       "leave it out"},
      {"desk3d", "[link]", "[plant]\nmass_kg = -1\n[link]", "[plant] mass_kg", "-1 is not an apparent mass",
       ">= 0.001"},
      {"desk3d", "\"point_arm\"", "\"stage\"", "[kinematics] upper_arm_m", "a stage has no links", "leave it out"},
      {"desk3d", "name = \"desk3d\"", "name = 3", "name", "3 is not text", "one line"},
  };
  for (const Case& c : cases) {
    const std::string text = spoilt(c.device, c.from, c.to), said = message(text);
    INFO(c.to << ": " << said);
    CHECK_THAT(said, Contains("my.toml:") && Contains(c.where) && Contains(c.what) && Contains(c.accepted));
  }
  const std::string text = spoilt("virtuose6d", "mass_kg = 0.3", "mass_kg = -1");
  CHECK_THAT(message(text), Catch::StartsWith("my.toml:" + std::to_string(line_of(text, "mass_kg = -1")) + ":11: "));
}

TEST_CASE("all missing keys are reported at once") {
  const std::string said = message("");
  for (const char* key : {"name", "kinematics", "workspace", "limits", "mechanics", "encoders", "link"})
    CHECK_THAT(said, Catch::Contains(std::string(key) + ": missing"));
  const std::string text = text_of(shipped("desk3d"));
  std::istringstream lines(text);
  unsigned keys = 0;
  for (std::string line; std::getline(lines, line);) {
    const std::size_t equals = line.find(" = ");
    if (line.empty() || line[0] == '#' || equals == std::string::npos) continue;
    ++keys;
    INFO(line);
    CHECK_THAT(message(spoilt("desk3d", line, "")),
               Catch::Contains(line.substr(0, equals) + ": missing") && Catch::Contains("accepted: "));
  }
  CHECK(keys == 14);
}

TEST_CASE("a file that is none, a folder, and one that is too long are refused in one line") {
  for (const char* path : {"/nowhere/device.toml", TACTUS_SOURCE_DIR "/hal"}) {
    const auto device = load_device_file(path);
    REQUIRE_FALSE(device.ok());
    CHECK_THAT(device.message(), Catch::Contains("cannot be read") && Catch::Contains("hal/devices/virtuose6d.toml"));
  }
  const std::string said = message(std::string(kMaxDeviceFileBytes + 1, ' '));
  CHECK_THAT(said, Catch::Contains("longer than 65536 bytes"));
  CHECK_THAT(message("name = "), Catch::StartsWith("my.toml:1:"));
}

TEST_CASE("the gain check reads a file's figures: half the damping allows less") {
  const auto allowed = [](const std::string& text) {
    const auto read = parse_device_description(text, "gain");
    REQUIRE(read.ok());
    hal::DeviceProfile profile = hal::make_profile(read.value());
    profile.properties.delay_s = profile.transport_delay_ticks * 1e-3;
    return haptics::check_coupling({}, profile.properties, 1e-3).translation.stiffness_limit;
  };
  // (b + B) / (T / 2 + t_d) with B = 5 N s/m, T = t_d = 1 ms, less at most 3 %: that line is for little damping.
  CHECK(allowed(text_of(shipped("virtuose6d"))) == Approx(5.5 / 1.5e-3).epsilon(0.03));
  CHECK(allowed(spoilt("virtuose6d", "damping_Ns_per_m = 0.5", "damping_Ns_per_m = 0.25")) ==
        Approx(5.25 / 1.5e-3).epsilon(0.03));
  CHECK(allowed(spoilt("virtuose6d", "transport_delay_ticks = 1", "transport_delay_ticks = 3")) ==
        Approx(5.5 / 3.5e-3).epsilon(0.03));
}
