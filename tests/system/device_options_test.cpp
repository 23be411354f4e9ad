// Which device a run asks for, what goes together with it, and what a tape keeps of it.
#include <nlohmann/json.hpp>

#include "sim/loader/scene_load.h"
#include "tests/support/temporary_file.h"
#include "tests/system/session_bench.h"
#include "tools/session/open_device.h"
#include "tools/session/replay.h"
#include "tools/session/stolen_time.h"
#include "tools/version/version.h"

using namespace tactus;
using namespace tactus::test;
using Catch::Matchers::Contains;

TEST_CASE("what a real device cannot do is refused before anything is opened") {
  session::RunOptions options;
  options.device = "usb";
  options.virtual_time = true;
  CHECK_THAT(check_options(options).message(), Contains("--virtual-time") && Contains("accepted: "));
  options.virtual_time = false;
  options.inject = "stall@5+5,lost@100";
  CHECK_THAT(check_options(options).message(), Contains("--inject") && Contains("usb") && Contains("accepted: "));
  options = {};
  options.virtual_time = true;
  options.gpio = "chip=gpiochip0,estop=0";
  CHECK_THAT(check_options(options).message(), Contains("--gpio") && Contains("accepted: "));
  options = {};
  options.gpio = "estop=0";
  CHECK_THAT(check_options(options).message(), Contains("--gpio") && Contains("accepted: "));
}

TEST_CASE("a tape brings back every property of the device, to the bit") {
  session::RunOptions options;
  options.device = "can:can0:7";
  options.scene = "here/x.toml";
  haptics::DeviceProperties device;
  device.has_rotation = false;
  device.max_force_N = 12.1;
  device.delay_s = 1.0 / 3.0;
  device.coulomb_friction_Nm = 4.9e-324;
  device.workspace_radius_m = 0.1 + 0.2;
  device.inertia_kg_m2 = 1e-3 / 7;
  const auto tape = session::from_tape_text(session::to_tape_text(options, device, "a scene", "title = \"x\""));
  INFO(tape.message());
  REQUIRE(tape.ok());
  CHECK(tape.value().options.device == "can:can0:7");
  CHECK(tape.value().made_by == "tactus " + version());
  CHECK(tape.value().scene_file == "here/x.toml");
  CHECK(tape.value().scene_hash == sim::source_hash("title = \"x\""));
  REQUIRE(tape.value().options.taped_device.has_value());
  const haptics::DeviceProperties& back = *tape.value().options.taped_device;
  CHECK(back.has_rotation == device.has_rotation);
  CHECK(back.max_force_N == device.max_force_N);
  CHECK(back.delay_s == device.delay_s);
  CHECK(back.coulomb_friction_Nm == device.coulomb_friction_Nm);
  CHECK(back.workspace_radius_m == device.workspace_radius_m);
  CHECK(back.inertia_kg_m2 == device.inertia_kg_m2);
}

TEST_CASE("a tape's header without one of the device's properties is refused by its name") {
  nlohmann::json text = nlohmann::json::parse(session::to_tape_text({}, {}, "a scene", ""));
  REQUIRE(session::from_tape_text(text.dump()).ok());
  text["device_properties"].erase("mass_kg");
  CHECK_THAT(session::from_tape_text(text.dump()).message(), Contains("'mass_kg'"));
  text.erase("device_properties");
  CHECK_THAT(session::from_tape_text(text.dump()).message(), Contains("'device_properties'"));
}

TEST_CASE("a replay takes the device from the tape and opens none") {
  session::RunOptions options;
  options.device = "usb:NOT-THERE";
  options.taped_device = haptics::DeviceProperties{};
  auto session = make_session(scene_text(kPressScene), options);
  CHECK(session->device->as<session::TapedDevice>() != nullptr);
  CHECK(session->simulated() == nullptr);
}

TEST_CASE("time stolen by the machine's host is the eighth column's share, of one core or of all") {
  // Per core: 100 ticks each in user, nice, system and idle, 0 elsewhere, then steal; guest columns are not counted.
  const std::string before =
      "cpu  200 200 200 200 0 0 0 10 5 5\ncpu0 100 100 100 100 0 0 0 10 5 5\n"
      "cpu1 100 100 100 100 0 0 0 0 0 0\nintr 1 2 3\n";
  const std::string after =
      "cpu  290 200 200 300 0 0 0 20 9 9\ncpu0 190 100 100 100 0 0 0 20 9 9\n"
      "cpu1 100 100 100 200 0 0 0 0 0 0\nintr 1 2 3\n";
  const auto share = [&](int cpu) {
    return session::stolen_share(session::cpu_time(before, cpu), session::cpu_time(after, cpu));
  };
  REQUIRE(share(0).has_value());
  CHECK(*share(0) == Approx(10.0 / 100.0));
  CHECK(*share(1) == Approx(0.0));
  CHECK(*share(-1) == Approx(10.0 / 200.0));
  CHECK_FALSE(share(2).has_value());
  CHECK_FALSE(session::cpu_time("cpu0 1 2 3\n", 0).has_value());  // a kernel of before the column
  CHECK_FALSE(session::stolen_share(session::cpu_time(after, 0), session::cpu_time(after, 0)).has_value());
}
