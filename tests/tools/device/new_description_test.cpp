// Descriptions from few figures: every kind of arm on every family is one that a run accepts.
#include "tools/device/new_description.h"

#include <catch2/catch.hpp>

#include "hal/device_file.h"
#include "hal/drives/bus_load.h"
#include "hal/profiles.h"

using namespace tactus;
using namespace tactus::device;
using Catch::Matchers::Contains;

TEST_CASE("every kind on every family makes a description that is accepted and fits its buses") {
  for (const char* kind : {"point_arm", "wristed_arm", "stage"})
    for (const char* family : {"damiao", "cubemars", "mini_cheetah", "robstride", "moteus", "odrive", "firmware"}) {
      CAPTURE(kind, family);
      NewDescription d;
      d.kind = kind;
      d.family = family;
      REQUIRE(check_choices(d).ok());
      complete(d);
      const auto parsed = hal::parse_device_description(description_text(d), "new");
      INFO((parsed.ok() ? "" : parsed.message()));
      REQUIRE(parsed.ok());
      CHECK(parsed.value().drives.axes.size() == (std::string(family) == "firmware"  ? 0u
                                                  : std::string(kind) == "point_arm" ? 3u
                                                                                     : 6u));
      CHECK(parsed.value().peak_force_N == d.peak_force_N);
      CHECK(parsed.value().workspace_radius_m == d.radius_m);
      CHECK(hal::check_bus_load(parsed.value().drives, std::chrono::nanoseconds(1'000'000'000 / d.rate_Hz)).ok());
      CHECK(consequences(parsed.value(), d.rate_Hz).size() >= 4);
      // The gain check counts the damping of the drives that have one.
      const hal::DeviceProfile profile = hal::make_profile(parsed.value());
      const bool damps = std::string(family) != "odrive" && std::string(family) != "firmware";
      CHECK((profile.drive_damping_Ns_per_m > 0.1) == damps);
    }
}

TEST_CASE("figures that are given are kept, those that are not become the family's") {
  NewDescription d;
  d.torque_range_Nm = 28;
  complete(d);
  CHECK(d.torque_range_Nm == 28);
  CHECK(d.position_range_rad == 12.5);
  CHECK(d.counts_per_turn == 0);
}

TEST_CASE("six drives on one classic bus are too many at 1 kHz") {
  NewDescription d;
  d.kind = "wristed_arm";
  d.buses = "can0";
  complete(d);
  const auto parsed = hal::parse_device_description(description_text(d), "new");
  REQUIRE(parsed.ok());
  CHECK_FALSE(hal::check_bus_load(parsed.value().drives, std::chrono::milliseconds(1)).ok());
}

TEST_CASE("an unknown kind, family, bus or a name with quotes is refused with what is accepted") {
  const auto refusal = [](auto change) {
    NewDescription d;
    change(d);
    return check_choices(d).message();
  };
  CHECK_THAT(refusal([](NewDescription& d) { d.kind = "arm"; }), Contains("point_arm, wristed_arm, stage"));
  CHECK_THAT(refusal([](NewDescription& d) { d.family = "vesc"; }), Contains("damiao, cubemars"));
  CHECK_THAT(refusal([](NewDescription& d) { d.name = "a\"b"; }), Contains("--name"));
  for (const char* buses : {"can0\"", ",", "can0,", "can0,can0", "a,b,c", "an_interface_of_16"})
    CHECK_THAT(refusal([&](NewDescription& d) { d.buses = buses; }), Contains("--buses") && Contains("can0,can1"));
}
