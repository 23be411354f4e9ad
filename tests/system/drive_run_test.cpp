// Whole runs on arms of drives: the same scene, the same loop, the drives' faults.
#include <nlohmann/json.hpp>

#include "hal/device_words.h"
#include "tests/system/session_bench.h"

using namespace tactus;
using namespace tactus::test;
using Catch::Matchers::Contains;

namespace {

const char* const kPointArm = TACTUS_SOURCE_DIR "/hal/devices/point_arm_drives.toml";
const char* const kWristedArm = TACTUS_SOURCE_DIR "/hal/devices/wristed_arm_moteus.toml";

session::RunOptions on_drives(const char* file, const char* inject = "") {
  session::RunOptions options = virtual_options();
  options.device = "drives-sim";
  options.device_file = file;
  options.inject = inject;
  return options;
}

}  // namespace

TEST_CASE("drives: a hand presses on a block through the drives, and nothing latches") {
  for (const char* file : {kPointArm, kWristedArm}) {
    CAPTURE(file);
    auto session = make_session(scene_text(kPressScene), on_drives(file));
    double most_N = 0;
    const session::RunSummary summary = run(*session, 3000, [&](const loop::TickOutput& out) {
      most_N = std::max(most_N, norm(out.command.wrench.force));
      return true;
    });
    CHECK(summary.stats.fault_count == 0);
    CHECK(most_N > 1.0);
    CHECK(summary.exit_code() == 0);
  }
}

TEST_CASE("drives: the same run has the same bits") {
  const auto hash = [](const char* inject) {
    auto session = make_session(scene_text(kPressScene), on_drives(kPointArm, inject));
    return run(*session, 1000).state_hash;
  };
  CHECK(hash("") == hash(""));
  CHECK(hash("") != hash("lost/state@500+5"));
}

TEST_CASE("drives: a lost bus and a restarted drive latch a fault, in words, and --rearm takes it back") {
  for (const char* inject : {"unplugged@800+30", "frozen@800+1"}) {
    CAPTURE(inject);
    session::RunOptions options = on_drives(kPointArm, inject);
    options.rearm = true;
    auto session = make_session(scene_text(kPressScene), options);
    const session::RunSummary summary = run(*session, 3000);
    REQUIRE(summary.stats.fault_count >= 1);
    CHECK(summary.stats.faults[0].tick < 850);
    const std::uint32_t said = summary.stats.faults[0].device_fault;
    if (*inject == 'f') CHECK_THAT(hal::describe_device_fault(said), Contains("is not enabled any more"));
    const nlohmann::json report = to_json(summary);
    CHECK(report["faults"][0]["device_fault"] == said % 256);  // the number alone, without the family and its code
    CHECK(session->driver->output().fault == Fault::kNone);
    CHECK((session->driver->output().status & kNotArmed) == 0);
  }
}

TEST_CASE("drives: what the rate does not allow, and a description without drives, are refused in one line") {
  const auto refusal = [](session::RunOptions options) {
    auto session = session::Session::create(scene_text(kPressScene), options);
    REQUIRE_FALSE(session.ok());
    CHECK(session.message().find('\n') == std::string::npos);
    return session.message();
  };
  session::RunOptions fast = on_drives(kPointArm);
  fast.rate_Hz = 2000;
  CHECK_THAT(refusal(fast), Contains("can0") && Contains("162 %") && Contains("--rate 1111"));
  session::RunOptions none = on_drives("");
  none.device_file.clear();
  CHECK_THAT(refusal(none), Contains("has no drives") && Contains("point_arm_drives.toml"));
}
