// Which gains a run uses: the scene's, or the most that its coupling bears.
#include "tools/session/scheme_gains.h"

#include <catch2/catch.hpp>
#include <string>

#include "tests/system/session_bench.h"
#include "tools/session/find_description.h"

using namespace tactus;
using namespace tactus::session;
using haptics::CouplingScheme;

namespace {

haptics::DeviceProperties device_of(const sim::Scene& scene) {
  const auto profile = find_description(scene.device.profile, {});
  REQUIRE(profile.ok());
  return profile.value().properties;
}

RunOptions options_of(CouplingScheme coupling) {
  RunOptions options = test::virtual_options();
  options.coupling = coupling;
  return options;
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("all couplings but interpolation use the scene's gains") {
  const sim::Scene scene = test::scene_file("stack20.toml");
  for (const auto coupling : haptics::kCouplingSchemes) {
    if (coupling == CouplingScheme::kInterpolation) continue;
    RunOptions options = options_of(coupling);
    options.keep_gains = true;
    const SchemeGains found = gains_of(scene, options, device_of(scene));
    CHECK_FALSE(found.lowered());
    CHECK(found.gains.stiffness_N_per_m == 1500);
    CHECK(check_gains(scene, options, device_of(scene)).ok());
    CHECK(lowered_text(found).empty());
  }
}

TEST_CASE("interpolation's stiffness is lowered to the allowed share of its limit, in both worlds, and said") {
  const sim::Scene scene = test::scene_file(GENERATE("stack20.toml", "card_house.toml", "workshop.toml"));
  const auto device = device_of(scene);
  RunOptions options = options_of(CouplingScheme::kInterpolation);
  const SchemeGains found = gains_of(scene, options, device);
  CHECK(found.lowered());
  CHECK(found.gains.stiffness_N_per_m <= haptics::kAllowedStiffnessShare * found.stiffness_limit_N_per_m);
  CHECK(found.gains.stiffness_N_per_m > 0.99 * haptics::kAllowedStiffnessShare * found.stiffness_limit_N_per_m);
  CHECK(found.gains.stiffness_Nm_per_rad <= haptics::kAllowedStiffnessShare * found.stiffness_limit_Nm_per_rad);
  CHECK(found.gains.damping_Ns_per_m == scene.coupling.damping_Ns_per_m);
  CHECK(loop_config(scene, options, device).sub_world.gains.stiffness_N_per_m == found.gains.stiffness_N_per_m);
  CHECK(global_options(scene, options, device).gains.stiffness_N_per_m == found.gains.stiffness_N_per_m);
  CHECK(global_options(scene, options, device).precision == physics::SweepPrecision::kFull);  // a small scene
  CHECK(contains(lowered_text(found), "N/m (limit "));
  CHECK(check_gains(scene, options, device).ok());
  // A ratio of 2 bears all of it.
  options.ratio = 2;
  CHECK_FALSE(gains_of(scene, options, device).lowered());
}

TEST_CASE("gains beyond the limit are refused with --keep-gains, with the stiffness that is accepted") {
  sim::Scene scene = test::scene_file("stack20.toml");
  const auto device = device_of(scene);
  RunOptions options = options_of(CouplingScheme::kInterpolation);
  const SchemeGains found = gains_of(scene, options, device);
  options.keep_gains = true;
  const std::string message = check_gains(scene, options, device).message();
  CAPTURE(message);
  CHECK(contains(message, "stiffness 1500 N/m with damping 5 N s/m is not stable with --coupling interpolation"));
  CHECK(contains(message, "at ratio 10, which delays the proxy by 10 ms"));
  CHECK(contains(message, "use stiffness_N_per_m = "));
  CHECK(contains(message, "lower --ratio"));
  CHECK_FALSE(Session::create(scene, options).ok());
  scene.coupling.stiffness_N_per_m = found.gains.stiffness_N_per_m;
  CHECK(contains(check_gains(scene, options, device).message(), "rotational"));
  scene.coupling.stiffness_Nm_per_rad = found.gains.stiffness_Nm_per_rad;
  CHECK(check_gains(scene, options, device).ok());
  scene.coupling.stiffness_N_per_m *= 1.02;
  CHECK_FALSE(check_gains(scene, options, device).ok());
}

TEST_CASE("a machine that wakes late delays the force: interpolation bears less, and a tape says how late") {
  const sim::Scene scene = test::scene_file("stack20.toml");
  const auto device = device_of(scene);
  RunOptions options = options_of(CouplingScheme::kInterpolation);
  const double prompt = gains_of(scene, options, device).gains.stiffness_N_per_m;
  options.late_s = 4e-4;
  CHECK(gains_of(scene, options, device).gains.stiffness_N_per_m < prompt);
  const auto tape = from_tape_text(to_tape_text(options, device, "stack20", scene.source));
  REQUIRE(tape.ok());
  CHECK(tape.value().options.late_s == options.late_s);
}
