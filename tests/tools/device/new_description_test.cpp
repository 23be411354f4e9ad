// Descriptions from few figures: every kind of arm on every family is one that a run accepts.
#include "tools/device/new_description.h"

#include <catch2/catch.hpp>

#include "hal/device_file.h"
#include "hal/drives/bus_load.h"
#include "hal/profiles.h"

using namespace tactus;
using namespace tactus::device;
using Catch::Matchers::Contains;

TEST_CASE("every kind on every family makes a description that is accepted") {
  for (const char* kind : {"point_arm", "wristed_arm", "stage"})
    for (const char* family : {"damiao", "cubemars", "mini_cheetah", "robstride", "moteus", "odrive", "firmware"}) {
      CAPTURE(kind, family);
      NewDescription d;
      d.kind = kind;
      d.family = family;
      d.buses = "can0,can1";
      d.ratio = 4;
      d.peak_torque_Nm = 0.2;
      if (d.kind == "stage")
        d.ratio = 20;  // rad per m of a belt, but the wrist turns by it, too: not on a drive's range
      REQUIRE(check_choices(d).ok());
      complete(d);
      if (d.kind != "point_arm") d.position_range_rad = d.position_range_rad == 0 ? 0 : 100;
      const auto parsed = hal::parse_device_description(description_text(d), "new");
      INFO((parsed.ok() ? "" : parsed.message()));
      REQUIRE(parsed.ok());
      CHECK(parsed.value().drives.axes.size() == (std::string(family) == "firmware"  ? 0u
                                                  : std::string(kind) == "point_arm" ? 3u
                                                                                     : 6u));
      CHECK(parsed.value().peak_force_N == d.peak_force_N);
      CHECK(parsed.value().workspace_radius_m == d.radius_m);
      CHECK(consequences(parsed.value(), 1000).size() >= 4);
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
  d.position_range_rad = 100;
  complete(d);
  const auto parsed = hal::parse_device_description(description_text(d), "new");
  REQUIRE(parsed.ok());
  CHECK_FALSE(hal::check_bus_load(parsed.value().drives, std::chrono::milliseconds(1)).ok());
}

TEST_CASE("an unknown kind, family or a name with quotes is refused with what is accepted") {
  const auto refusal = [](auto change) {
    NewDescription d;
    change(d);
    return check_choices(d).message();
  };
  CHECK_THAT(refusal([](NewDescription& d) { d.kind = "arm"; }), Contains("point_arm, wristed_arm, stage"));
  CHECK_THAT(refusal([](NewDescription& d) { d.family = "vesc"; }), Contains("damiao, cubemars"));
  CHECK_THAT(refusal([](NewDescription& d) { d.name = "a\"b"; }), Contains("--name"));
  CHECK_THAT(refusal([](NewDescription& d) { d.buses = "can0\""; }), Contains("--buses"));
}
