#include <algorithm>
#include <catch2/catch.hpp>

#include "hal/profiles.h"
#include "rt/haptics/coupling_limits.h"
#include "sim/loader/scene_report.h"
#include "tests/system/session_bench.h"

using namespace tactus;

namespace {

Status created(const haptics::CouplingGains& gains, double late_s = 0) {
  sim::Scene scene = test::scene_text(test::kPressScene);
  scene.coupling = gains;
  session::RunOptions options = test::virtual_options();
  options.late_s = late_s;
  return session::Session::create(std::move(scene), options).status();
}

double number_behind(const std::string& said, const std::string& words) {
  INFO(said);
  REQUIRE(said.find(words) != std::string::npos);
  return std::stod(said.substr(said.find(words) + words.size()));
}

}  // namespace

TEST_CASE("a run refuses gains beyond the limit in one line, and what it says to use it accepts") {
  haptics::CouplingGains gains;
  gains.stiffness_N_per_m = 5000;
  const std::string said = created(gains).message();
  CHECK_THAT(said, Catch::Contains("not stable at 1000 Hz"));
  CHECK(std::count(said.begin(), said.end(), '\n') == 0);
  gains.stiffness_N_per_m = number_behind(said, "accepted: stiffness_N_per_m up to ");
  CHECK(created(gains).ok());

  gains.damping_Ns_per_m = 1e4;
  const std::string damped = created(gains).message();
  gains.damping_Ns_per_m = number_behind(damped, ", such as ");
  gains.stiffness_N_per_m = number_behind(damped, " with stiffness_N_per_m = ");
  CHECK(created(gains).ok());
}

TEST_CASE("with a motion scale all figures are those that stand in the scene") {
  sim::Scene scene = test::scene_text(test::kPressScene);
  scene.device.motion_scale = 2;
  scene.coupling.stiffness_N_per_m = 5000;
  const auto said = session::Session::create(scene, test::virtual_options()).status().message();
  CHECK_THAT(said, Catch::Contains("stiffness_N_per_m = 5000 with"));
  CHECK_THAT(said, Catch::EndsWith("at the hand 4 times as much"));
  scene.coupling.stiffness_N_per_m = number_behind(said, "stiffness_N_per_m up to ");
  CHECK(session::Session::create(scene, test::virtual_options()).ok());
  const auto report = sim::report_on(scene, hal::find_profile(scene.device.profile)->properties, 1e-3);
  CHECK(report.coupling.translation.stiffness == Approx(scene.coupling.stiffness_N_per_m));
}

TEST_CASE("gains that are stable for the device may be unstable on a machine that wakes the loop late") {
  const haptics::CouplingGains gains;  // of a scene that says nothing
  CHECK(created(gains).ok());
  const std::string said = created(gains, 0.4e-3).message();
  CHECK_THAT(said, Catch::Contains("that wakes up to 400 us late"));
}
