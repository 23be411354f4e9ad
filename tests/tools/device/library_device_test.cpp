// A device through its maker's library as a user has it: `tactus hil` and `tactus doctor` on the stand-in for HD.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/support/run_command.h"

using namespace tactus;
using Catch::Matchers::Contains;

namespace {

const std::string kDevice = " --device openhaptics:" TACTUS_STAND_IN_HD;

test::CommandOutput run(const std::string& arguments) {
  return test::run_command(TACTUS_PROGRAM " " + arguments + " 2>&1");
}

}  // namespace

TEST_CASE("openhaptics: hil finds the stand-in's states as they should be, and asks before it opens it") {
  const test::CommandOutput asked = run("hil </dev/null" + kDevice);
  CHECK(asked.exit_code == 3);
  CHECK_THAT(asked.out, Contains("nothing was opened; agree, or give --yes"));
  // What this machine's load changes is not judged here: the samples' share and their way.
  const test::CommandOutput output = test::run_command(
      TACTUS_PROGRAM " hil --yes --json --timing report --only identity,enable,brake,not-finite,watchdog" + kDevice +
      " 2>/dev/null");
  INFO(output.out);
  CHECK(output.exit_code == 0);
  const auto report = nlohmann::json::parse(output.out);
  CHECK(report["checks"].size() == 5);
  for (const auto& check : report["checks"]) CHECK(check["verdict"] == "good");
}

TEST_CASE("openhaptics: doctor says which library it is, or that there is none") {
  CHECK_THAT(run("doctor" + kDevice).out, Contains("3D Systems' library HD is " TACTUS_STAND_IN_HD));
  const test::CommandOutput none = run("doctor --device openhaptics:/nowhere");
  CHECK(none.exit_code == 1);
  CHECK_THAT(none.out, Contains("library HD is not found") && Contains("accepted: openhaptics:FOLDER"));
}
