// The hardware-in-the-loop suite against the firmware in the same process: a good device is good, and each kind of bad
// one is found by the check that is there for it.
#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/tools/hil/hil_bench.h"

using namespace tactus;
using namespace tactus::test;
using Catch::Matchers::Contains;
using hil::CheckVerdict;

TEST_CASE("hil: a good device passes every check that applies to it") {
  const char* profile = GENERATE("virtuose6d", "desk3d");
  hil::HilOptions options;
  options.force_N = 2;
  options.soak_frames = 3000;
  HilBench bench({}, options, profile);
  const hil::SuiteReport report = run_suite(bench.bench, {{}, true}, {});
  CHECK(report.checks.size() == hil::all_checks().size());
  for (const auto& one : report.checks) {
    INFO(profile << ", " << one.check->name << ": " << one.finding.measured << "; " << one.finding.reason);
    const bool for_can = std::string(one.check->name) == "bus-off";
    CHECK(one.finding.verdict == (for_can ? CheckVerdict::kSkipped : CheckVerdict::kGood));
  }
  CHECK(report.good());
}

TEST_CASE("hil: frames to fade and to safe are the firmware's own: 3 and 10, one for the e-stop") {
  HilBench bench;
  const auto watchdog = bench.check("watchdog");
  CHECK(figure(watchdog, "frames_to_fade") == 3);
  CHECK(figure(watchdog, "frames_to_safe") == 10);
  for (const char* name : {"broken-commands", "repeated-commands"})
    CHECK(figure(bench.check(name), "frames_to_safe") == 10);
  CHECK(figure(bench.check("e-stop"), "frames_to_safe") == 1);
  CHECK(figure(bench.check("not-finite"), "frames_to_safe") == 1);
  CHECK(figure(bench.check("brake"), "frames_to_safe") == 1);
}

TEST_CASE("hil: without leave the motors stay off, and without --force nothing is pushed") {
  HilBench bench;
  const auto report = run_suite(bench.bench, {{"watchdog", "force", "losses"}, false}, {});
  REQUIRE(report.checks.size() == 3);
  CHECK(report.checks[0].finding.verdict == CheckVerdict::kGood);  // losses, in the table's order
  CHECK(report.checks[1].finding.verdict == CheckVerdict::kSkipped);
  CHECK(report.checks[2].finding.verdict == CheckVerdict::kSkipped);
  // At rest it never left IDLE: no motor had an effort.
  const auto& device = bench.link.as<TamperedLink>()->bench.truth();
  CHECK(device.device().controller().state() == firmware::State::kIdle);
  CHECK_THAT(bench.check("force").reason, Contains("--force"));
}

TEST_CASE("hil: a push goes the way that it should, as far as a mass under a force goes") {
  hil::HilOptions options;
  options.force_N = 3;
  HilBench bench({}, options);
  const auto finding = bench.check("force");
  // Half the acceleration times the square of 20 ms, of arm and hand, less what friction and the hand take: not more.
  const double mass_kg = bench.profile.properties.mass_kg + hal::HandParameters{}.mass_kg;
  const double free_m = 0.5 * 3.0 / mass_kg * 0.02 * 0.02;
  for (const char* axis : {"moved_x_m", "moved_y_m", "moved_z_m"}) {
    CHECK(figure(finding, axis) > 0.3 * free_m);
    CHECK(figure(finding, axis) < 1.05 * free_m);
  }
}

TEST_CASE("hil: the force limit is as it was after the check of saturation") {
  HilBench bench;
  const auto before = bench.bench.read(firmware::number::kMaxForce);
  CHECK(bench.check("saturation").verdict == CheckVerdict::kGood);
  const auto after = bench.bench.read(firmware::number::kMaxForce);
  REQUIRE((before.ok() && after.ok()));
  CHECK(before.value() == after.value());
}

TEST_CASE("hil: lost, repeated and renumbered frames are each found and named") {
  const auto every = [](std::uint64_t n) { return [n](std::uint64_t i) { return i > 0 && i % n == 0; }; };
  SECTION("lost") {
    HilBench bench({.lose_state = every(100)});
    const auto finding = bench.check("losses");
    CHECK(finding.verdict == CheckVerdict::kBad);
    CHECK_THAT(finding.reason, Contains("lost"));
    CHECK(figure(finding, "lost") == Approx(50).margin(1));
    CHECK(figure(finding, "unaccounted") == 0);
  }
  SECTION("a few lost are counted, and good") {
    HilBench bench({.lose_state = every(2000)});
    const auto finding = bench.check("losses");
    CHECK(finding.verdict == CheckVerdict::kGood);
    CHECK(figure(finding, "lost") >= 1);
  }
  SECTION("lost in a row") {
    HilBench bench({.lose_state = [](std::uint64_t i) { return i % 4000 < 3; }});
    CHECK_THAT(bench.check("losses").reason, Contains("gaps"));
  }
  SECTION("repeated") {
    HilBench bench({.repeat_state = every(500)});
    const auto finding = bench.check("losses");
    CHECK(finding.verdict == CheckVerdict::kBad);
    CHECK(figure(finding, "duplicated") == Approx(10).margin(1));
  }
  SECTION("in the wrong order") {
    HilBench bench(
        {.alter_state = [&](std::uint64_t i, firmware::StateFrame& f) { f.sequence -= i % 1000 == 999 ? 5 : 0; }});
    const auto finding = bench.check("losses");
    CHECK(finding.verdict == CheckVerdict::kBad);
    CHECK(figure(finding, "reordered") == 5);
  }
}

TEST_CASE("hil: a command with NaN that a newer one replaces is sent again") {
  const auto has_nan = [](const firmware::CommandFrame& f) { return !std::isfinite(f.effort[0]); };
  SECTION("twice, then it leaves") {
    int replaced = 0;
    HilBench bench(
        {.supersede_command = [&](const firmware::CommandFrame& f) { return has_nan(f) && ++replaced <= 2; }});
    CHECK(figure(bench.check("not-finite"), "frames_to_safe") == 1);
    CHECK(replaced == 3);
  }
  SECTION("always: that the device brakes is not shown") {
    HilBench bench({.supersede_command = has_nan});
    CHECK(bench.check("not-finite").verdict == CheckVerdict::kBad);
  }
}

TEST_CASE("hil: a device clock that runs fast is measured to one part in a million") {
  const double ppm = GENERATE(-2000.0, -400.0, 400.0, 2000.0);
  HilBench bench({.alter_state = [&](std::uint64_t, firmware::StateFrame& f) {
    f.time_us += static_cast<std::uint64_t>(static_cast<std::int64_t>(static_cast<double>(f.time_us) * ppm * 1e-6));
  }});
  const auto finding = bench.check("clock");
  CHECK(figure(finding, "drift_ppm") == Approx(ppm).margin(1));
  CHECK((finding.verdict == CheckVerdict::kBad) == (std::abs(ppm) > 500));
}

TEST_CASE("hil: a device that brakes late, or does not stay in BRAKE, is bad") {
  using firmware::State;
  SECTION("a watchdog that says that it counts slower") {
    HilBench bench({.alter_state = [](std::uint64_t, firmware::StateFrame& f) {
      if (f.missed_commands > 0 && f.missed_commands < 200)
        f.missed_commands = static_cast<std::uint8_t>(f.missed_commands + 4);
    }});
    const auto finding = bench.check("watchdog");
    CHECK(finding.verdict == CheckVerdict::kBad);
    CHECK_THAT(finding.reason, Contains("when it should"));
  }
  SECTION("an e-stop that is told and does not brake") {
    HilBench bench({.alter_state = [](std::uint64_t, firmware::StateFrame& f) {
      if (f.state == State::kBrake) {
        f.state = State::kForce;
        f.fault = 0;
      }
    }});
    const auto finding = bench.check("e-stop");
    CHECK(finding.verdict == CheckVerdict::kBad);
    CHECK_THAT(finding.reason, Contains("never braked"));
  }
  const std::uint16_t emergency_stop = bit_of(firmware::Limit::kEmergencyStop);
  SECTION("an e-stop that brakes after three frames more") {
    std::uint64_t active = 0;
    HilBench bench({.alter_state = [&](std::uint64_t, firmware::StateFrame& f) {
      active = (f.limits & emergency_stop) != 0 ? active + 1 : 0;
      if (active >= 1 && active <= 3) f.state = State::kForce;
    }});
    const auto finding = bench.check("e-stop");
    CHECK(figure(finding, "frames_to_safe") == 4);
    CHECK(finding.verdict == CheckVerdict::kBad);
  }
  SECTION("an e-stop that is forgotten when it is released") {
    HilBench bench({.alter_state = [&](std::uint64_t, firmware::StateFrame& f) {
      if (f.fault == 2 && (f.limits & emergency_stop) == 0) {
        f.state = State::kIdle;
        f.fault = 0;
      }
    }});
    CHECK_THAT(bench.check("e-stop").reason, Contains("re-arm"));
  }
  SECTION("a brake without a latch") {
    std::uint64_t braked = 0;
    HilBench bench({.alter_state = [&braked](std::uint64_t, firmware::StateFrame& f) {
      braked = f.state == State::kBrake ? braked + 1 : 0;
      if (braked > 100) f.state = State::kForce;
    }});
    CHECK_THAT(bench.check("brake").reason, Contains("re-arm"));
  }
  SECTION("limits that are not reported") {
    HilBench bench({.alter_state = [](std::uint64_t, firmware::StateFrame& f) { f.limits = 0; }});
    CHECK_THAT(bench.check("saturation").reason, Contains("not reported"));
    CHECK_THAT(bench.check("watchdog").reason, Contains("fade"));
  }
}

TEST_CASE("hil: a device of another description is found by its identity") {
  HilBench bench;
  hal::DeviceProfile other = bench.profile;
  other.quantum[1] *= 2;
  hil::Bench suspicious(bench.link, other, bench.provoker, bench.options);
  const auto report = run_suite(suspicious, {{"identity"}, true}, {});
  CHECK(report.checks.front().finding.verdict == CheckVerdict::kBad);
  CHECK_THAT(report.checks.front().finding.reason, Contains("axis 1") && Contains("quantum"));
  hil::HilOptions fast = bench.options;
  fast.rate_Hz = 2000;
  hil::Bench other_rate(bench.link, bench.profile, bench.provoker, fast);
  CHECK_THAT(run_suite(other_rate, {{"identity"}, true}, {}).checks.front().finding.reason, Contains("--rate"));
}

TEST_CASE("hil: a check that leaves the device in BRAKE for good is bad, whatever it found") {
  HilBench bench;
  bench.link.as<TamperedLink>()->bench.emergency_stop = true;  // and stays pressed
  const auto finding = bench.check("losses");
  CHECK(finding.verdict == CheckVerdict::kBad);
  CHECK_THAT(finding.reason, Contains("e-stop"));
}

TEST_CASE("hil: on the loop's own thread every period is a record", "[threads]") {
  hil::HilOptions options;
  options.quiet_s = 0.3;
  options.judge_timing = false;
  options.setup = {.priority = 0, .lock_memory = false, .hold_cpu_awake = false};
  const auto& profile = *hal::find_profile("desk3d");
  hal::AnyLink link(std::make_unique<hil::SimulatedBench>(profile, kHilPeriod_ns));
  hil::ProvokeSimulated provoker(*link.as<hil::SimulatedBench>());
  hil::Bench bench(link, profile, provoker, options);
  const auto& quiet = bench.quiet();
  REQUIRE(quiet.ok());
  CHECK(quiet.value().result.records.size() == 300);
  CHECK(quiet.value().counts.lost() == 0);
  CHECK(quiet.value().counts.fresh == 300);
  CHECK(quiet.value().result.timing.ticks >= 300);
  const auto report = run_suite(bench, {{"e-stop", "unplug", "watchdog"}, true}, {});
  for (const auto& one : report.checks) {
    INFO(one.check->name << ": " << one.finding.reason);
    CHECK(one.finding.verdict == CheckVerdict::kGood);
  }
}

TEST_CASE("hil: reports count what they show, and XML and JSON hold any text") {
  HilBench bench;
  hil::SuiteReport report = run_suite(bench.bench, {{"losses", "bus-off", "clock"}, true}, {});
  report.device = "usb:<\"&'>";
  report.checks[1].finding.verdict = CheckVerdict::kBad;
  report.checks[1].finding.reason = "a < b & c > \"d\"\n";
  const std::string xml = to_junit(report);
  CHECK_THAT(xml, Contains("tests=\"3\" failures=\"1\" skipped=\"1\""));
  CHECK_THAT(xml, Contains("a &lt; b &amp; c &gt; &quot;d&quot;"));
  CHECK(std::count(xml.begin(), xml.end(), '<') == std::count(xml.begin(), xml.end(), '>'));
  const auto json = nlohmann::json::parse(to_json_text(report));
  CHECK(json["good"] == 1);
  CHECK(json["bad"] == 1);
  CHECK(json["skipped"] == 1);
  CHECK(json["verdict"] == "bad");
  CHECK(json["checks"][0]["figures"]["lost"] == 0);
  CHECK_FALSE(report.good());
}

TEST_CASE("hil: a fault is provoked by a command, and skipped where the command cannot") {
  HilBench bench;
  const auto yes = hil::provoke_by_command("test"), no = hil::provoke_by_command("false");
  CHECK(yes->set("estop = estop -o", true).ok());  // the command gets the fault's name and on or off
  CHECK_FALSE(no->set("estop", true).ok());
  hil::Bench refused(bench.link, bench.profile, *no, bench.options);
  const auto report = run_suite(refused, {{"e-stop", "unplug", "broken-states"}, true}, {});
  for (const auto& one : report.checks) CHECK(one.finding.verdict == CheckVerdict::kSkipped);
  CHECK_FALSE(report.good());  // nothing was seen to be good
}
