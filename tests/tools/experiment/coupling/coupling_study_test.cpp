#include "tools/experiment/coupling/coupling_study.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tools/experiment/coupling/reference_run.h"

using namespace tactus;
using namespace tactus::experiment;

namespace {

StudyReport study_of(const std::string& scene, const std::vector<Scheme>& schemes, unsigned seeds = 1) {
  StudyRequest request;
  for (const CouplingCase& one : coupling_cases())
    if (one.name == scene) request.cases.push_back(one);
  request.schemes = schemes;
  request.seeds = seeds;
  request.quick = true;
  auto report = run_coupling_study(request, {});
  REQUIRE(report.ok());
  return std::move(report).value();
}

constexpr auto kDirect = haptics::CouplingScheme::kDirect;
constexpr auto kSubWorld = haptics::CouplingScheme::kSubWorld;

}  // namespace

TEST_CASE("All seven scenes load, and every hand but the first is another") {
  CHECK(coupling_cases().size() == 7);
  for (const CouplingCase& one : coupling_cases()) {
    INFO(one.name);
    const auto written = load_coupling_case(one, 0), other = load_coupling_case(one, 7),
               same = load_coupling_case(one, 7);
    REQUIRE(written.ok());
    REQUIRE(other.ok());
    CHECK(written.value().hand.path[1].position_m != other.value().hand.path[1].position_m);
    CHECK(same.value().hand.path[1].position_m == other.value().hand.path[1].position_m);
    CHECK(one.members < written.value().bodies.size());
  }
}

TEST_CASE("The direct coupling measured against itself has no error") {
  const StudyReport report = study_of("peg", {{kDirect, physics::BorderMode::kCapped, 1}});
  REQUIRE(report.rows.size() == 1);
  const StudyRow& row = report.rows[0];
  CHECK(row.force_error == 0);
  CHECK(row.energy.loss == 0);
  CHECK(row.energy.gain == 0);
  CHECK(row.hold_vibration_N == 0);
  CHECK(row.hold_vibration_encoder_N == 0);
  CHECK(row.stable);
  CHECK(report.scenes[0].contact_share > 0.8);
  CHECK(report.scenes[0].apart_force_error > 0);
}

TEST_CASE("Each hand's figures stand beside those of all, which lie among them") {
  const StudyReport report = study_of("chain", {{kSubWorld, physics::BorderMode::kFrozen, 8}}, 2);
  REQUIRE(report.rows.size() == 1);
  const StudyRow& row = report.rows[0];
  REQUIRE(row.by_seed.size() == 2);
  const auto [least, most] = std::minmax(row.by_seed[0].force_error, row.by_seed[1].force_error);
  CHECK(least < most);
  CHECK(row.force_error > least);
  CHECK(row.force_error < most);
  const auto json = nlohmann::json::parse(study_json(report));
  CHECK(json["rows"][0]["by_seed"][1]["force_error_rms"] == row.by_seed[1].force_error);
  // The first of two is the only one of one: hands are counted down.
  const StudyRow alone = study_of("chain", {{kSubWorld, physics::BorderMode::kFrozen, 8}}).rows[0];
  CHECK(alone.by_seed.size() == 1);
  CHECK(alone.by_seed[0].force_error == row.by_seed[1].force_error);
}

TEST_CASE("A border costs accuracy, and what the study says is in its JSON and its CSV") {
  const StudyReport report = study_of("chain", {{kSubWorld, physics::BorderMode::kFrozen, 8}});
  REQUIRE(report.rows.size() == 1);
  CHECK(report.scenes[0].component == 25);
  CHECK(report.scenes[0].members == 8);
  CHECK(report.rows[0].force_error > 0.01);  // a row of cubes that cannot move
  const auto json = nlohmann::json::parse(study_json(report));
  for (const char* key : {"scene", "coupling", "border", "ratio", "loss", "gain", "force_error_rms", "sync_step_N",
                          "hold_vibration_N", "stable"})
    CHECK(json["rows"][0].contains(key));
  const std::string csv = study_csv(report);
  const auto commas = [&](std::size_t from, std::size_t to) {
    return std::count(csv.begin() + static_cast<std::ptrdiff_t>(from), csv.begin() + static_cast<std::ptrdiff_t>(to),
                      ',');
  };
  const std::size_t first_line = csv.find('\n');
  CHECK(commas(0, first_line) == commas(first_line + 1, csv.size()));
}

TEST_CASE("A force far beyond the direct coupling's is not stable, nor a shaking one, nor one that is gone") {
  const HandInLoop direct{2, 0.01, 1.8, 0, 0};
  CHECK(is_stable(direct, direct));
  CHECK_FALSE(is_stable({4.1, 0.01, 1.8, 0, 0}, direct));
  CHECK_FALSE(is_stable({2, 0.22, 1.8, 0, 0}, direct));
  CHECK_FALSE(is_stable({2, 0.01, 0.8, 0, 0}, direct));
}

TEST_CASE("With the force of the direct coupling it is not stable where a body falls or energy comes from nowhere") {
  const HandInLoop direct{2, 0.01, 1.8, 0, 0};
  CHECK_FALSE(is_stable({2, 0.01, 1.8, 1, 0}, direct));
  CHECK(is_stable({2, 0.01, 1.8, 0, 0.99 * kMaxEnergyGain}, direct));
  CHECK_FALSE(is_stable({2, 0.01, 1.8, 0, 1.01 * kMaxEnergyGain}, direct));
}

TEST_CASE("A scene with more bodies than a sub-world holds has no windows, and is told how it runs without them") {
  auto pile = case_of_file(TACTUS_SOURCE_DIR "/sim/scenes/pile700.toml");
  REQUIRE(pile.ok());
  StudyRequest request;
  request.cases.push_back(std::move(pile).value());
  request.seeds = 1;
  const auto report = run_coupling_study(request, {});
  REQUIRE(!report.ok());
  CHECK(report.status().message() ==
        "pile700: 701 bodies move, and a window starts with all of them in the sub-world; accepted: up to 256; "
        "--seeds 0 --whole 10 runs the scene without windows");
}

TEST_CASE("Every ratio has as many cycles in a window, but for the spectrum's least and the script's most") {
  CHECK(window_ticks(8) == 25 * 8);
  CHECK(window_ticks(16) == 25 * 16);
  CHECK(window_ticks(1) == kWindowTicks);
  CHECK(window_ticks(100) == kLongestWindow);
  for (const bool quick : {false, true})
    for (const WindowPlace& place : window_places(quick)) {
      const std::size_t end = place.start + kLongestWindow;
      CHECK(end <= tick_at(place.hold ? HandTimes::kHeld : HandTimes::kEnd));
      CHECK(place.start >= tick_at(place.hold ? HandTimes::kPressed : HandTimes::kHeld));
    }
}
