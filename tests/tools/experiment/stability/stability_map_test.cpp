#include "tools/experiment/stability/stability_map.h"

#include <catch2/catch.hpp>

#include <nlohmann/json.hpp>

using namespace tactus;
using namespace tactus::experiment;

namespace {

const hal::DeviceDescription& device() { return hal::find_profile("virtuose6d")->description; }

double limit(const LoopTiming& timing, double damping, double late_s = 0) {
  const auto axis = haptics::translation_of(device_in(device(), timing), 1 / timing.rate_Hz, late_s);
  return haptics::uncoupled_stiffness_limit(axis, damping);
}

}  // namespace

TEST_CASE("The device in the loop is the description's, with the delay and the quantum that are asked for") {
  const auto in_loop = device_in(device(), {.rate_Hz = 1000, .delay_ticks = 2.5, .jitter_ticks = 0, .quantum_m = 3e-5});
  CHECK(in_loop.mass_kg == device().mass_kg);
  CHECK(in_loop.damping_Ns_per_m == device().damping_Ns_per_m);
  CHECK(in_loop.delay_s == Approx(2.5e-3));
  CHECK(in_loop.position_quantum_m == 3e-5);
  CHECK(device_in(device(), {.rate_Hz = 4000, .delay_ticks = 0}).delay_s == Approx(50e-6));  // a part at the least
}

TEST_CASE("A tap rings out below the limit and rings on above it") {
  const LoopTiming timing{.rate_Hz = 1000, .delay_ticks = 1};
  const double at = limit(timing, 5);
  CHECK(rings_out(device(), timing, haptics::kAllowedStiffnessShare * at, 5));
  CHECK(rings_out(device(), timing, at, 5));
  CHECK_FALSE(rings_out(device(), timing, 2.2 * at, 5));
}

// The coupling's target moves on with the device's velocity while a tick is solved, in four sub-steps: the force is of
// 5/8 of a tick ahead of its sample, which takes as much of the delay away.
TEST_CASE("The measured boundary is that of the delay less the coupling's lead, and the formula is below it") {
  for (const double delay_ticks : {1.0, 2.0, 3.0}) {
    const LoopTiming timing{.rate_Hz = 1000, .delay_ticks = delay_ticks};
    const double measured = measured_limit(device(), timing, 5, 1000, 10000, 1.03);
    CHECK(measured == Approx(5.5 / (0.5e-3 + delay_ticks * 1e-3 - 0.625e-3)).epsilon(0.1));
    CHECK(limit(timing, 5) < measured);
  }
}

TEST_CASE("Late ticks and a coarse encoder take stiffness away, but not below what is allowed") {
  const auto measured = [](const LoopTiming& timing) { return measured_limit(device(), timing, 5, 1000, 10000, 1.05); };
  const double ideal = measured({.rate_Hz = 1000, .delay_ticks = 1});
  const double late = measured({.rate_Hz = 1000, .delay_ticks = 1, .jitter_ticks = 0.9});
  const double coarse = measured({.rate_Hz = 1000, .delay_ticks = 1, .jitter_ticks = 0, .quantum_m = 5e-5});
  CHECK(late < ideal);
  CHECK(coarse < ideal);
  CHECK(late > limit({.rate_Hz = 1000, .delay_ticks = 1}, 5, 0.9e-3));
  CHECK(coarse > haptics::kAllowedStiffnessShare * limit({.rate_Hz = 1000, .delay_ticks = 1}, 5));
}

TEST_CASE("The map's JSON has every boundary with its formula, and the gains for this PC") {
  MapRequest request;
  request.description = device();
  request.wake = {1e-6, 50e-6, 90e-6, "made up", false};
  MapReport report;
  report.wake = request.wake;
  report.rows.push_back({"delay", {1000, 3, 0, 0}, 3e-3, 5, 1500, 1528, 1571, 856});
  report.suggested = haptics::suggest_gains({}, 1e-3, request.wake.late_s);
  const auto json = nlohmann::json::parse(map_json(report));
  CHECK(json["rows"][0]["measured_N_per_m"] == 1500);
  CHECK(json["rows"][0]["formula_N_per_m"] == 1528);
  CHECK(json["wake"]["p99_9_us"] == Approx(50));
  CHECK(json["suggested"]["stiffness_N_per_m"] == Approx(report.suggested.stiffness_N_per_m));
  CHECK_THAT(map_csv(report), Catch::StartsWith("factor,rate [Hz]"));
}
