// Each rule of the verdict's table, broken alone, makes a run degraded or bad, with the rule's text.
#include "tools/session/verdict.h"

#include <bit>
#include <catch2/catch.hpp>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>

#include "tests/system/session_bench.h"

using namespace tactus;
using namespace tactus::session;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

// A good run of one minute in real time.
RunSummary good_run() {
  RunSummary s;
  s.scene_name = "test";
  s.ratio = 10;
  s.real_time = s.has_global = true;
  s.stats.ticks = s.timing.ticks = 60'000;
  s.stats.cycles = 6'000;
  s.global.energy.complete = true;
  s.global.energy.most_kinetic_J = 0.1;
  return s;
}

std::uint64_t& ticks_of(RunSummary& s, StatusBit bit) {
  return s.stats.status_ticks[std::countr_zero(static_cast<std::uint32_t>(bit))];
}

void fail_step(RunSummary& s, bool privilege) {
  loop::SetupStep step;
  step.name = "kernel";
  step.ok = false;
  step.privilege = privilege;
  REQUIRE(s.setup.steps.try_push(step));
}

struct Case {
  const char* rule;
  Level level;
  const char* words;
  std::function<void(RunSummary&)> make;
};

}  // namespace

TEST_CASE("a run without findings is good, in one word") {
  const RunVerdict verdict = judge(good_run());
  CHECK(verdict.level() == Level::kGood);
  CHECK(verdict.line() == "good");
  CHECK(verdict.text().empty());
  CHECK(verdict.exit_code() == 0);
  CHECK(verdict.rulings.size() == 12);
}

TEST_CASE("each rule alone makes a run degraded or bad, says why with the figure, and its remedy") {
  const Case cases[] = {
      {"fault", Level::kBad, "a fault is latched",
       [](RunSummary& s) {
         REQUIRE(s.stats.faults.try_push({5, Fault::kEmergencyStop, 0}));
       }},
      {"faults", Level::kDegraded, "2 faults latched and taken back",
       [](RunSummary& s) {
         s.stats.fault_count = 2;
         for (const std::uint32_t cleared : {0u, 1u, 0u, 1u})
           REQUIRE(s.stats.faults.try_push({5, Fault::kEmergencyStop, cleared}));
       }},
      {"samples", Level::kDegraded, "in 20 ticks no sample came, in 5 it was refused",
       [](RunSummary& s) {
         s.stats.ticks = 2000;
         s.stats.status_ticks[0] = 20;
         s.stats.status_ticks[2] = 5;
       }},
      {"own-work", Level::kBad, "1 ticks were lost to the program's own work",
       [](RunSummary& s) { s.overruns_own_work = 1; }},
      {"scene", Level::kBad, "bodies 1 and 2 overlap by 0.02 m",
       [](RunSummary& s) { s.scene_problems = {"bodies 1 and 2 overlap by 0.02 m"}; }},
      {"overlap", Level::kDegraded, "bodies 3 and 7 overlapped by 1.10 mm, 11 %",
       [](RunSummary& s) {
         s.global.overlap = {0.11, 1.1e-3, 3, 7};
       }},
      {"overlap", Level::kBad, "51 % of the thinner one's thickness",
       [](RunSummary& s) {
         s.global.overlap = {0.51, 5.1e-3, 3, 7};
       }},
      {"overlap", Level::kBad, "two bodies overlapped", [](RunSummary& s) { s.stats.deepest_share = 0.51; }},
      {"energy", Level::kDegraded, "0.011 J more", [](RunSummary& s) { s.global.energy.unexplained_J = 0.011; }},
      {"energy", Level::kBad, "0.026 J more", [](RunSummary& s) { s.global.energy.unexplained_J = 0.026; }},
      {"border", Level::kDegraded, "nothing left to give in 601 of 60000 ticks",
       [](RunSummary& s) { ticks_of(s, kBorderSpent) = 601; }},
      {"border", Level::kBad, "6001 of 60000", [](RunSummary& s) { ticks_of(s, kBorderSpent) = 6'001; }},
      {"capacity", Level::kDegraded, "12 entries were left out",
       [](RunSummary& s) {
         s.stats.capacity_bits = 1;
         s.stats.dropped = 12;
       }},
      {"capacity", Level::kDegraded, "a capacity was exceeded", [](RunSummary& s) { s.global.capacity_bits = 1; }},
      {"deadlines", Level::kDegraded, "lost 45 deadlines: 40 ticks late, 5 skipped",
       [](RunSummary& s) {
         s.overruns_late_wake = 30;
         s.overruns_interrupted = 10;
         s.timing.skipped_ticks = 5;
       }},
      {"clock", Level::kDegraded, "its clock lost 650 of 60000 ms", [](RunSummary& s) { s.stats.cycles -= 65; }},
      {"set-up", Level::kDegraded, "without kernel", [](RunSummary& s) { fail_step(s, false); }},
      {"set-up", Level::kDegraded, "without kernel", [](RunSummary& s) { fail_step(s, true); }},
  };
  for (const Case& one : cases) {
    CAPTURE(one.rule, one.words);
    RunSummary s = good_run();
    one.make(s);
    const RunVerdict verdict = judge(s);
    CHECK(verdict.level() == one.level);
    CHECK(verdict.exit_code() == (one.level == Level::kBad ? 1 : 0));
    CHECK(s.exit_code() == verdict.exit_code());
    CHECK_THAT(verdict.line(), StartsWith(one.level == Level::kBad ? "BAD: " : "DEGRADED: ") && Contains(one.words));
    for (const RunRuling& ruling : verdict.rulings) {
      CHECK(ruling.level() == (ruling.rule == one.rule ? one.level : Level::kGood));
      if (ruling.rule == one.rule) CHECK_THAT(verdict.text(), Contains(ruling.found) && Contains(ruling.remedy));
    }
    const auto json = to_json(s);
    CHECK(json["level"] == name_of(one.level));
    CHECK(json["verdict"] == verdict.line());
    CHECK(json["exit_code"] == verdict.exit_code());
  }
}

TEST_CASE("just within its limits a run is good") {
  RunSummary s = good_run();
  s.global.overlap = {0.10, 1e-3, 3, 7};
  s.stats.deepest_share = 0.099;
  s.global.energy.unexplained_J = 0.0099;
  ticks_of(s, kBorderSpent) = 600;
  s.overruns_late_wake = 4;
  s.timing.skipped_ticks = 2;
  s.timing.ticks -= 2;   // 6 of 60 000
  s.stats.cycles -= 60;  // 600 ms
  CHECK(judge(s).line() == "good");
}

TEST_CASE("one late tick of a short run is not deadlines in numbers, two are") {
  CHECK(most_lost_of_10000(100'000) == 1);
  CHECK(most_lost_of_10000(2'000) == 5);
  RunSummary s = good_run();
  s.stats.ticks = s.timing.ticks = 2'000;
  s.stats.cycles = 200;
  s.overruns_late_wake = 1;
  CHECK(judge(s).level() == Level::kGood);
  s.overruns_late_wake = 2;
  CHECK(judge(s).level() == Level::kDegraded);
}

TEST_CASE("the energy rule says nothing where the balance is not complete, and nothing of microjoules") {
  RunSummary s = good_run();
  s.global.energy.unexplained_J = 5;
  s.global.energy.complete = false;
  CHECK(judge(s).level() == Level::kGood);
  for (const RunRuling& ruling : judge(s).rulings) CHECK(ruling.rule != "energy");
  s.global.energy.complete = true;
  CHECK(judge(s).level() == Level::kBad);
  s.global.energy.most_kinetic_J = 1e-6;
  s.global.energy.unexplained_J = 1e-4;
  CHECK(judge(s).level() == Level::kGood);
}

TEST_CASE("bad is named before degraded, and a figure that is no number is bad") {
  RunSummary s = good_run();
  ticks_of(s, kBorderSpent) = 601;
  s.global.overlap = {std::numeric_limits<double>::quiet_NaN(), 0, 3, 7};
  s.stats.deepest_share = 0.6;
  const RunVerdict verdict = judge(s);
  CHECK_THAT(verdict.line(), StartsWith("BAD: two bodies"));
  CHECK(verdict.text().find("bad ") < verdict.text().find("degraded "));
  s.global.energy.unexplained_J = std::numeric_limits<double>::quiet_NaN();
  CHECK(RunRuling{.rule = "x",
                  .figure = "x",
                  .unit = "",
                  .measured = std::numeric_limits<double>::quiet_NaN(),
                  .degraded_above = 1,
                  .bad_above = 2,
                  .found = "",
                  .remedy = "",
                  .machine = false}
            .level() == Level::kBad);
}

namespace {

// The second ball begins `overlap_m` deep in the first, and pushes out.
std::string two_balls(double overlap_m) {
  return R"(
title = "two balls"
effects = ["friction"]
[simulation]
ratio = 10
members = 8
[device]
position_m = [0, 0, 0.3]
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
position_m = [0, 0, 0.3]
[[body]]
shape = "sphere"
radius_m = 0.02
mass_kg = 0.5
friction = 0.5
position_m = [0, 0, 0]
[[body]]
shape = "sphere"
radius_m = 0.02
mass_kg = 0.5
friction = 0.5
position_m = [0, 0, )" +
         std::to_string(0.04 - overlap_m) + "]\n";
}

struct Judged {
  RunSummary summary;
  sim::SceneReport report;
};

Judged run_text(const std::string& text, haptics::CouplingScheme coupling) {
  RunOptions options = test::virtual_options();
  options.coupling = coupling;
  const auto session = test::make_session(test::scene_text(text), options);
  auto report = sim::report_on(session->scene, session->device->properties(), options.period_s());
  return {test::run(*session, 500), std::move(report)};
}

const RunRuling& ruling_of(const RunVerdict& verdict, const std::string& rule) {
  for (const RunRuling& ruling : verdict.rulings)
    if (ruling.rule == rule) return ruling;
  FAIL(rule);
  return verdict.rulings.front();
}

}  // namespace

TEST_CASE("what `scene check` calls bad is bad when it runs, in the same words: two balls 2 cm deep") {
  const auto coupling = GENERATE(haptics::CouplingScheme::kSubWorld, haptics::CouplingScheme::kDirect);
  const Judged run = run_text(two_balls(0.021), coupling);
  const RunVerdict verdict = judge(run.summary), of_scene = judge(run.report);
  CHECK(of_scene.level() == Level::kBad);
  CHECK(of_scene.exit_code() == 1);
  CHECK(verdict.level() == Level::kBad);
  CHECK(ruling_of(verdict, "scene").found == of_scene.rulings.front().found);
  CHECK_THAT(verdict.text(), Contains("overlap by 0.021 m at the start"));
  // 21 mm of a ball of 40 mm, in both worlds.
  CHECK(ruling_of(verdict, "overlap").measured == Approx(100 * 0.021 / 0.04).epsilon(0.1));
  CHECK(ruling_of(verdict, "overlap").level() == Level::kBad);
}

TEST_CASE("the same balls side by side are good") {
  const auto coupling = GENERATE(haptics::CouplingScheme::kSubWorld, haptics::CouplingScheme::kDirect);
  const Judged run = run_text(two_balls(-0.001), coupling);
  CAPTURE(judge(run.summary).text());
  CHECK(judge(run.summary).level() == Level::kGood);
  CHECK(judge(run.report).level() == Level::kGood);
}
