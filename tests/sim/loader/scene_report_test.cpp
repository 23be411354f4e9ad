// What `tactus scene check` tells of a scene's masses.
#include <catch2/catch.hpp>

#include "sim/loader/scene_load.h"
#include "sim/loader/scene_report.h"

using namespace tactus;
using namespace tactus::sim;

TEST_CASE("a body that follows a script is not among the masses") {
  const auto scene = parse_scene(R"(effects = ["kinematic"]
[proxy]
shape = "sphere"
radius_m = 0.01
mass_kg = 0.2
[[body]]
shape = "sphere"
radius_m = 0.01
mass_kg = 0.4
position_m = [1, 0, 0]
[[body]]
shape = "box"
size_m = [0.1, 0.1, 0.1]
kinematic = true
velocity_m_per_s = [0.1, 0, 0]
position_m = [2, 0, 0]
)",
                                 "x.toml");
  INFO(scene.message());
  REQUIRE(scene.ok());
  const SceneReport report = report_on(scene.value(), haptics::DeviceProperties{}, 1e-3);
  CHECK(report.lightest_kg == 0.2);
  CHECK(report.heaviest_kg == 0.4);
  CHECK(report.mass_ratio == 2.0);
}
