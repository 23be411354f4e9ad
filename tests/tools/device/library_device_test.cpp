// A device through its maker's library as a user has it: `tactus hil` and `tactus doctor` on the stand-ins for the
// libraries, whole and with faults of a library.
#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/support/run_command.h"
#include "tests/support/temporary_file.h"

using namespace tactus;
using Catch::Matchers::Contains;
using Catch::Matchers::Matches;
using Catch::Matchers::StartsWith;

namespace {

const std::string kTouch = "openhaptics:" TACTUS_STAND_IN_HD, kOmega = "dhd:" TACTUS_STAND_IN_DHD;

test::CommandOutput run(const std::string& arguments) {
  return test::run_command(TACTUS_PROGRAM " " + arguments + " 2>&1");
}

// --timing report: the share of samples and their delay depend on this machine's load and are not judged.
std::string hil(const std::string& device, const std::string& only) {
  return "hil --yes --force 1 --timing report --device " + device + " --only " + only;
}

// The message about an exchange of 50 ms: hil reads it before the exchange ends, or after.
const std::string kBlocks = R"(its library (took [0-9.]+ ms for an exchange|makes no exchange since [0-9]+ ms: ))";

struct HilRun {
  int exit_code{0};
  nlohmann::json report;
  std::string end;  // the state of the forces that the library reported when the device was closed
};

HilRun run_hil_once(const std::string& device, const std::string& only, const std::string& fault) {
  const test::TemporaryFile end;
  const test::CommandOutput output =
      test::run_command("TACTUS_STAND_IN_FAULT=" + fault + " TACTUS_STAND_IN_END=" + end.path() +
                        " " TACTUS_PROGRAM " " + hil(device, only) + " --json 2>/dev/null");
  INFO(output.out);
  std::string said;
  for (const std::byte byte : end.read()) said += static_cast<char>(byte);
  return {output.exit_code, nlohmann::json::parse(output.out), said};
}

bool lacks_samples(const nlohmann::json& report) {
  const auto& checks = report["checks"];
  return std::any_of(checks.begin(), checks.end(), [](const nlohmann::json& check) {
    const std::string reason = check["reason"];
    return reason.find("sends no samples, or few") != std::string::npos || reason.starts_with("samples are missing");
  });
}

// Repeats a run that lacks samples. A loaded machine may not run the library's thread for ten periods, which ends the
// force; a library that loses samples does so in every run.
template <class Run, class Lacks>
auto run_with_samples(Run run, Lacks lacks) {
  auto result = run();
  for (int again = 0; again < 4 && lacks(result); ++again) result = run();
  return result;
}

// `fault`: KIND@MOMENT, see stand_in/script.h.
HilRun run_hil(const std::string& device, const std::string& only, const std::string& fault) {
  return run_with_samples([&] { return run_hil_once(device, only, fault); },
                          [](const HilRun& result) { return lacks_samples(result.report); });
}

}  // namespace

TEST_CASE("dhd, openhaptics: hil finds the stand-ins' states as they should be, and says what it cannot see") {
  const std::string device = GENERATE(kTouch, kOmega);
  const HilRun result = run_hil(device, "identity,samples,round-trip,enable,brake,not-finite,watchdog", "");
  CHECK(result.exit_code == 0);
  CHECK(result.report["checks"].size() == 7);
  for (const auto& check : result.report["checks"]) {
    CAPTURE(check.dump());
    CHECK(check["verdict"] == "good");
    const std::string name = check["name"];
    CHECK((check["not_checked"] != "") == (name == "round-trip" || name == "watchdog"));
    if (name == "watchdog")
      CHECK_THAT(check["not_checked"], Contains(device == kTouch ? "none is known in the device" : "after 10 ms"));
  }
  CHECK(result.report["left_in"] == "IDLE");
  CHECK(result.end == "forces off\n");
}

TEST_CASE("dhd, openhaptics: hil asks before it opens a device") {
  const test::CommandOutput asked = run("hil </dev/null --device " + GENERATE(kTouch, kOmega));
  CHECK(asked.exit_code == 3);
  CHECK_THAT(asked.out, Contains("nothing was opened; agree, or give --yes"));
}

TEST_CASE("dhd, openhaptics: a fault of the library in a push ends the force, and hil says why and how it left it") {
  struct Case {
    std::string device, fault, why;
  };
  const Case c = GENERATE(values<Case>({
      {kOmega, "blocks", kBlocks},
      {kOmega, "errors", "its library refuses exchanges"},
      {kOmega, "old", "its library gives the old sample again"},
      {kOmega, "gone", "its library says that the device is not there"},
      {kTouch, "blocks", kBlocks},
      {kTouch, "errors", "its library refuses exchanges"},
      {kTouch, "stops", "calls no more"},
      {kTouch, "fast", "the arm moved too fast"},
      {kTouch, "gone", "its library lost the device"},
      {kTouch, "backwards", "clock ran backwards"},
  }));
  CAPTURE(c.device, c.fault);
  const HilRun result = run_hil(c.device, "force", c.fault + "@push");
  CHECK(result.exit_code == 1);
  CHECK(result.report["verdict"] == "bad");
  const auto& check = result.report["checks"][0];
  CHECK(check["verdict"] == "bad");
  CHECK_THAT(check["reason"], Matches(".*" + c.why + ".*"));
  CHECK_THAT(result.report["left_in"], Matches("BRAKE: .*" + c.why + ".*"));
  CHECK(result.end == "forces off\n");
}

TEST_CASE("dhd, openhaptics: a library that refuses forces is bad in each check that wants them, and brakes") {
  const std::string device = GENERATE(kTouch, kOmega);
  const HilRun result = run_hil(device, "enable,brake,not-finite,watchdog,force", "off@on");
  CHECK(result.exit_code == 1);
  for (const auto& check : result.report["checks"]) {
    CAPTURE(check.dump());
    CHECK(check["verdict"] == "bad");
    CHECK_THAT(check["reason"], Contains("BRAKE, device fault"));
  }
  CHECK(result.end == "forces off\n");
}

TEST_CASE("dhd, openhaptics: a library that fails at rest is bad in words, and so is each check after it") {
  const auto [device, fault, why] = GENERATE(table<std::string, std::string, std::string>(
      {{kOmega, "blocks", kBlocks}, {kTouch, "backwards", "clock ran backwards"}}));
  const HilRun result = run_hil(device, "samples,enable,watchdog", fault + "@rest");
  CHECK(result.exit_code == 1);
  CHECK(result.report["bad"] == 3);
  for (const auto& check : result.report["checks"]) CHECK_THAT(check["reason"], Matches(".*" + why + ".*"));
  CHECK(result.end == "forces off\n");
}

TEST_CASE("dhd: a library that does not return while it pushes leaves hil to say so, and to end") {
  const HilRun result = run_hil(kOmega, "force", "hangs@push");
  CHECK(result.exit_code == 1);
  CHECK_THAT(result.report["left_in"], StartsWith("BRAKE: ") && Contains("it does not return"));
  CHECK(result.end.empty());  // it was never closed
}

TEST_CASE("openhaptics: the table says what is not checked, what is bad and how the device is left") {
  const test::CommandOutput output = run_with_samples(
      [] {
        return test::run_command("TACTUS_STAND_IN_FAULT=backwards@on " TACTUS_PROGRAM " " +
                                 hil(kTouch, "watchdog,force") + " 2>/dev/null");
      },
      [](const test::CommandOutput& result) { return Contains("sends no samples, or few").match(result.out); });
  CHECK(output.exit_code == 1);
  CHECK_THAT(output.out, Contains("  watchdog           bad") && Contains("not checked: what brakes here is tactus'") &&
                             Contains("0 good, 2 bad, 0 skipped") && Contains("the device is left in BRAKE: ") &&
                             Contains("clock ran backwards"));
}

TEST_CASE("openhaptics: doctor says which library it is, or that there is none") {
  CHECK_THAT(run("doctor --device " + kTouch).out, Contains("3D Systems' library HD is " TACTUS_STAND_IN_HD));
  const test::CommandOutput none = run("doctor --device openhaptics:/nowhere");
  CHECK(none.exit_code == 1);
  CHECK_THAT(none.out, Contains("library HD is not found") && Contains("accepted: openhaptics:FOLDER"));
}
