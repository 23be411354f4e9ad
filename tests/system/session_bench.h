// Whole sessions for tests: a scene of the project or of the test, run on the virtual clock.
#pragma once

#include <catch2/catch.hpp>
#include <string>

#include "sim/loader/scene_load.h"
#include "tools/session/virtual_run.h"

namespace tactus::test {

inline sim::Scene scene_file(const std::string& name) {
  auto scene = sim::load_scene(std::string(TACTUS_SOURCE_DIR "/sim/scenes/") + name);
  INFO(scene.message());
  REQUIRE(scene.ok());
  return std::move(scene).value();
}

inline sim::Scene scene_text(const std::string& text) {
  auto scene = sim::parse_scene(text, "test");
  INFO(scene.message());
  REQUIRE(scene.ok());
  return std::move(scene).value();
}

inline session::RunOptions virtual_options() {
  session::RunOptions options;
  options.virtual_time = true;
  options.duration_s = 1;
  return options;
}

inline std::unique_ptr<session::Session> make_session(sim::Scene scene, const session::RunOptions& options) {
  auto session = session::Session::create(std::move(scene), options);
  INFO(session.message());
  REQUIRE(session.ok());
  return std::move(session).value();
}

inline session::RunSummary run(session::Session& session, std::uint64_t ticks,
                               const session::TickObserver& observer = {}) {
  auto summary = session::run_virtual(session, ticks, observer);
  INFO(summary.message());
  REQUIRE(summary.ok());
  return std::move(summary).value();
}

// A hand presses a ball onto a block on the ground with about 2 N, after half a second, and stays. Small and quick.
inline const char* const kPressScene = R"(
title = "Press on a block"
effects = ["gravity", "friction", "gyroscopic"]
[simulation]
ratio = 10
members = 8
[device]
position_m = [0, 0, 0.12]
[coupling]
stiffness_N_per_m = 1500
damping_Ns_per_m = 5
stiffness_Nm_per_rad = 4
damping_Nms_per_rad = 0.02
[proxy]
shape = "sphere"
radius_m = 0.01
mass_kg = 0.2
friction = 0.5
position_m = [0, 0, 0.115]
[[body]]
shape = "plane"
friction = 0.5
[[body]]
shape = "box"
size_m = [0.1, 0.1, 0.1]
mass_kg = 1
friction = 0.5
position_m = [0, 0, 0.05]
[hand]
repeat = false
path = [
  {time_s = 0.0, position_m = [0, 0, 0.115]},
  {time_s = 0.5, position_m = [0, 0, 0.104]},
  {time_s = 0.6, position_m = [0, 0, 0.104]},
]
)";

}  // namespace tactus::test
