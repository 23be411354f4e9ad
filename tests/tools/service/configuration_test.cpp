// The deployment's configuration: what it reads as, what is wrong with it, what may change while it runs.
#include "tools/service/configuration.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>

using Catch::Matchers::Contains;

using namespace tactus;
using namespace tactus::service;

namespace {

Configuration good(const std::string& text) {
  const auto configuration = parse_configuration(text, "/etc/tactus/tactus.toml");
  INFO(configuration.message());
  REQUIRE(configuration.ok());
  return configuration.value();
}

}  // namespace

TEST_CASE("a configuration reads as the options of a run, its paths from its own folder") {
  const auto c = good(R"(scene = "../scenes/wall.toml"
[device]
name = "can:can0"
file = "device.toml"
[rates]
rate_Hz = 500
ratio = 5
[cores]
haptic = 3
priority = 70
world = "1-2"
world_threads = 2
[limits]
members = 20
budget = "budget.json"
[control]
socket = "/run/tactus/control"
arm_at_start = false
rearm = true
[log]
interval_s = 10
)");
  CHECK(c.run.scene == "/etc/tactus/../scenes/wall.toml");
  CHECK(c.run.device == "can:can0");
  CHECK(c.run.device_file == "/etc/tactus/device.toml");
  CHECK(c.run.rate_Hz == 500);
  CHECK(c.run.ratio == 5);
  CHECK(c.run.cpu == 3);
  CHECK(c.run.priority == 70);
  CHECK(c.run.world_cpus == std::vector<int>{1, 2});
  CHECK(c.run.world_threads == 2);
  CHECK(c.run.members == 20);
  CHECK(c.budget == "/etc/tactus/budget.json");
  CHECK(c.socket == "/run/tactus/control");
  CHECK_FALSE(c.run.arm_at_start);
  CHECK(c.run.rearm);
  CHECK(c.log_interval_s == 10);
}

TEST_CASE("all but the scene has a default") {
  const auto c = good("scene = \"/a.toml\"\n");
  CHECK(c.run.scene == "/a.toml");
  CHECK(c.run.device == "sim");
  CHECK(c.run.cpu == -1);
  CHECK(c.run.ratio == 0);
  CHECK(c.run.members == 0);
  CHECK(c.socket.empty());
  CHECK_FALSE(c.run.arm_at_start);
}

TEST_CASE("[[device]] is a device of each hand, with its file and its core, and the lines of all") {
  const auto c = good(R"(scene = "two.toml"
[[device]]
name = "usb:0001"
file = "left.toml"
core = 2
gpio = "chip=gpiochip0,estop=3-low"
[[device]]
name = "can:can0"
core = 3
[cores]
priority = 70
)");
  REQUIRE(c.devices.size() == 2);
  CHECK(c.devices[0] == ConfiguredDevice{"usb:0001", "/etc/tactus/left.toml", 2});
  CHECK(c.devices[1] == ConfiguredDevice{"can:can0", {}, 3});
  CHECK(c.run.gpio == "chip=gpiochip0,estop=3-low");
  CHECK(c.run.priority == 70);
  CHECK(c.run.cpu == -1);
  // Given once it is [device].
  const auto one = good("scene = \"/a.toml\"\n[[device]]\nname = \"usb\"\n");
  CHECK(one.devices.empty());
  CHECK(one.run.device == "usb");
  CHECK(needs_restart(c, one) == "scene, [device], [cores]");
  CHECK(good("scene = \"/a.toml\"\n[device]\nname = \"usb\"\n").devices.empty());
}

TEST_CASE("what several devices cannot have is a mistake with its line") {
  const std::string text = R"(scene = "/a.toml"
[[device]]
core = 9
[[device]]
name = "nonesuch"
gpio = "chip=gpiochip0,estop=3"
[cores]
haptic = 1
)";
  const auto reading = read_configuration(text, "t.toml", std::vector<int>{0, 1});
  for (const char* says : {"t.toml:3:8: [device.1] core: this machine has no core 9",
                           "t.toml:6:8: [device.2] gpio: the lines are of all hands; accepted: gpio of the first",
                           "t.toml:8:10: [cores] haptic: is of one hand; accepted: core in each [[device]]",
                           "t.toml:5:8: [device.2] name: 'nonesuch' is no device; accepted: sim, usb"})
    CHECK_THAT(reading.mistakes, Contains(says));
  CHECK_THAT(read_configuration("scene = \"/a.toml\"\n[device]\ncore = 1\n", "t.toml", std::nullopt).mistakes,
             Contains("[device] core: is of several devices; accepted: [cores] haptic"));
}

TEST_CASE("every mistake has its line, and none hides the next one") {
  const auto bad = parse_configuration(R"([device]
name = 4
[rates]
rate_Hz = 5
[cores]
world = "one"
prioritty = 80
)",
                                       "tactus.toml");
  REQUIRE_FALSE(bad.ok());
  for (const char* says : {"scene", "tactus.toml:2:", "tactus.toml:4:11: [rates] rate_Hz: 5 is not a rate",
                           "tactus.toml:6:", "is no list of cores", "did you mean priority?"})
    CHECK_THAT(bad.message(), Contains(says));
}

TEST_CASE("what does not go together is a mistake of the file") {
  const auto bad = parse_configuration("scene = \"a\"\n[cores]\nworld = \"1-3\"\nworld_threads = 2\n", "t.toml");
  REQUIRE_FALSE(bad.ok());
  CHECK_THAT(bad.message(), Contains("3 cores for 2 of --world-threads"));
  CHECK_FALSE(parse_configuration(std::string(kMaxConfigurationBytes + 1, '#'), "t.toml").ok());
  CHECK_FALSE(parse_configuration("scene = ", "t.toml").ok());
}

TEST_CASE("a core that the machine has not, and a socket without an absolute path, are mistakes with their lines") {
  const std::string text = R"(scene = "/a.toml"
[cores]
haptic = 4
world = "1,7"
world_threads = 3
[control]
socket = "control"
)";
  const auto reading = read_configuration(text, "t.toml", std::vector<int>{0, 1, 2, 3});
  CHECK_THAT(reading.mistakes,
             Contains("t.toml:3:10: [cores] haptic: this machine has no core 4; accepted: one of 0, 1"));
  CHECK_THAT(reading.mistakes, Contains("t.toml:4:9: [cores] world: this machine has no core 7"));
  CHECK_THAT(reading.mistakes, Contains("2 cores for 3 of --world-threads"));
  CHECK_THAT(reading.mistakes, Contains("t.toml:7:10: [control] socket: 'control' is no place for a socket"));
  CHECK(std::count(reading.mistakes.begin(), reading.mistakes.end(), '\n') == 3);  // between four lines
  CHECK(reading.configuration.run.scene == "/a.toml");
  CHECK_THAT(
      read_configuration("scene = \"/a\"\n[control]\nsocket = \"/" + std::string(107, 'x') + "\"\n", "t.toml", {})
          .mistakes,
      Contains("up to 107 characters"));
}

TEST_CASE("re-arming and the log may change while it runs, the rest needs a restart and is named") {
  const auto before = good("scene = \"/a.toml\"\n");
  CHECK(needs_restart(before, good("scene = \"/a.toml\"\n[control]\nrearm = true\n[log]\ninterval_s = 5\n")).empty());
  CHECK(needs_restart(before, good("scene = \"/b.toml\"\n[rates]\nrate_Hz = 2000\n")) == "scene, [rates]");
  CHECK(needs_restart(before, good("scene = \"/a.toml\"\n[control]\nsocket = \"/s\"\n")) == "[control] socket");
}

TEST_CASE("the configuration that is installed is good") {
  std::ifstream file(TACTUS_SOURCE_DIR "/tools/deploy/tactus.toml");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  CHECK(good(text).socket == "/run/tactus/control");
}
