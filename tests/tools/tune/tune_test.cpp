#include "tools/tune/tune.h"

#include <catch2/catch.hpp>

#include <nlohmann/json.hpp>

#include "sim/loader/scene_load.h"
#include "tests/system/session_bench.h"

using namespace tactus;
using namespace tactus::tune;

namespace {

TuneReport made_up() {
  TuneReport report;
  report.file = "my.toml";
  report.scene = "my";
  report.scene_hash = "0123";
  report.limits = {.tick_us = 600, .global_us = 800, .members = 256, .sub_steps = 16, .bodies = 40};
  report.chosen.setting = {.sub_steps = 8, .relax_sweeps = 2, .contact_Hz = 250, .members = 40, .scheme = {.ratio = 4}};
  report.chosen.tick_us_p99 = 400;
  report.chosen.force_error = 0.02;
  FurtherStep step;
  step.change = {"sub-steps", "8", "16", report.chosen.setting};
  step.change.setting.sub_steps = 16;
  step.trial = {step.change.setting, 0.015, 700, 790, 100};
  report.further.push_back(step);
  step.change = {"contact frequency [Hz]", "250", "500", report.chosen.setting};
  step.change.setting.contact_Hz = 500;
  step.trial = {step.change.setting, 0.9, 400, 410, 150};
  step.fits = true;
  report.further.push_back(step);
  return report;
}

}  // namespace

TEST_CASE("The lines for the scene make it what was chosen") {
  const TuneReport report = made_up();
  std::string text = test::kPressScene;
  const std::string written = "[simulation]\nratio = 10\nmembers = 8\n";
  REQUIRE(text.find(written) != std::string::npos);
  text.replace(text.find(written), written.size(), snippet_of(report));
  const auto scene = sim::parse_scene(text, "tuned");
  INFO(scene.message());
  REQUIRE(scene.ok());
  CHECK(scene.value().solver.sub_steps == 8);
  CHECK(scene.value().solver.relax_sweeps == 2);
  CHECK(scene.value().members == 40);
  CHECK(scene.value().ratio == 4);
  CHECK(command_of(report) == "tactus run my.toml --members 40 --ratio 4");
}

TEST_CASE("A further step says what it buys, what it costs and whether it fits") {
  const auto json = nlohmann::json::parse(tune_json(made_up()));
  CHECK(json["scene_file"] == "my.toml");
  CHECK(json["scene_hash"] == "0123");
  const std::string first = json["further"][0]["sentence"], second = json["further"][1]["sentence"];
  CHECK_THAT(first, Catch::Contains("sub-steps 8 -> 16: saves 0.500 % of force error, costs 390 us a tick") &&
                        Catch::Contains("does not fit: a tick of 790 us, 600 are allowed"));
  CHECK_THAT(second, Catch::Contains("overlaps a quarter as deep") && Catch::EndsWith("fits"));
}

TEST_CASE("A real run holds where next to nothing was given up and no tick was lost to own work") {
  RealRun run;
  CHECK(run.holds());
  run.late_share = 0.02;
  CHECK_FALSE(run.holds());
  run = {};
  run.lost = 1;
  CHECK_FALSE(run.holds());
  run = {};
  run.reduced_share = 0.02;
  CHECK_FALSE(run.holds());
}

TEST_CASE("A choice is not good where the scene itself is bad, and the text says so") {
  TuneReport report;
  report.fits = true;
  CHECK(report.good());
  CHECK(tune_text(report).find("the scene itself") == std::string::npos);
  session::RunRuling overlap;
  overlap.measured = 80;
  overlap.bad_above = 50;
  report.of_scene.rulings.push_back(overlap);
  CHECK_FALSE(report.good());
  CHECK(tune_text(report).starts_with("the scene itself is BAD"));
}

TEST_CASE("A scene of more bodies than a run of all of them may have is refused in one line") {
  TuneRequest request;
  request.scene = test::scene_file("pile700.toml");
  const std::atomic<bool> stop{false};
  const auto report = run_tune(request, {}, stop);
  REQUIRE_FALSE(report.ok());
  CHECK_THAT(report.message(), Catch::Contains("moving bodies; accepted: up to 256"));
}
