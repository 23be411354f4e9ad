// A whole run on a device behind a link: the same frames as on a cable, the firmware at the other end in this process.
#include "hal/loopback_link.h"
#include "tests/support/temporary_file.h"
#include "tests/system/session_bench.h"
#include "tools/session/open_link.h"
#include "tools/session/realtime_run.h"
#include "tools/session/replay.h"

using namespace tactus;
using namespace tactus::test;
using Catch::Matchers::Contains;

namespace {

constexpr std::int64_t kPeriod_ns = 1'000'000;
using Device = hal::DeviceOnLink<hal::AnyLink>;

// The hand of kPressScene, in the device's frame (its origin is at z = 0.12 in the world): onto the block and back.
hal::HandModel pressing_hand() {
  const std::vector<hal::HandWaypoint> path = {
      {0.0, {0, 0, -0.005}, {}}, {0.5, {0, 0, -0.016}, {}}, {0.6, {0, 0, -0.016}, {}}};
  return hal::HandModel({}, path);
}

struct LinkedRun {
  explicit LinkedRun(const char* profile_name = "virtuose6d") {
    const auto& profile = *hal::find_profile(profile_name);
    auto link = std::make_unique<hal::AnyLink>(
        std::make_unique<hal::LoopbackLink>(profile, pressing_hand(), kPeriod_ns, hal::LoopbackLink::Stamp::kClock));
    loopback = link->as<hal::LoopbackLink>();
    session::Hardware hardware;
    hardware.device = std::make_unique<hal::AnyDevice>(std::make_unique<Device>(profile, kPeriod_ns, std::move(link)));
    hardware.identity = "a link in this process";
    session::RunOptions options;
    options.device = "usb", options.priority = 0, options.duration_s = 2;
    auto made = session::Session::create(scene_text(kPressScene), options, std::move(hardware));
    INFO(made.message());
    REQUIRE(made.ok());
    session = std::move(made).value();
  }

  hal::LoopbackLink* loopback{nullptr};
  std::unique_ptr<session::Session> session;
};

}  // namespace

TEST_CASE("a run on a device behind a link presses, and its tape replays to the same bits without the device") {
  const TemporaryFile tape;
  LinkedRun linked;
  REQUIRE(linked.session->record(tape.path()).ok());
  linked.session->options.record = tape.path();
  const auto summary = run(*linked.session, 2500);
  CHECK(summary.stats.contact_ticks > 1000);
  CHECK(summary.stats.fault_count == 0);
  CHECK(summary.stats.force_max_N > 1.0);
  REQUIRE(summary.link.has_value());
  CHECK(summary.link->lost == 0);
  CHECK(summary.link->reads.fresh == 2500);
  CHECK(linked.loopback->device().controller().state() == firmware::State::kForce);
  linked.session.reset();
  const auto report = session::replay(tape.path());
  INFO(report.message());
  REQUIRE(report.ok());
  INFO(report.value().first_difference);
  CHECK(report.value().good());
  CHECK(report.value().compared == 2500);
  CHECK(report.value().state_hash == summary.state_hash);
}

TEST_CASE("an unplugged device latches a fault, and what its link counted is in the summary") {
  LinkedRun linked;
  run(*linked.session, 1500, [&](const loop::TickOutput& out) {
    if (out.tick == 1000) linked.loopback->set_plugged(false);
    return true;
  });
  session::RunSummary summary = linked.session->summary();
  CHECK(summary.stats.fault_count == 1);
  CHECK(summary.stats.faults.items[0].fault == Fault::kDeviceUnplugged);
  CHECK(summary.exit_code() == 1);
  REQUIRE(summary.link.has_value());
  CHECK(summary.link->link.disconnects == 1);
  CHECK(summary.link->reads.disconnected > 450);
  const std::string text = to_text(summary);
  CHECK_THAT(text, Contains("a link in this process"));
  CHECK_THAT(text, Contains("1 disconnects"));
  CHECK_THAT(text, !Contains("by the motors"));  // nobody knows it of a real device
}

TEST_CASE("a built-in description is found by its name, one in a file by its path, and what is none is refused") {
  const auto built_in = session::find_description("desk3d", {});
  REQUIRE(built_in.ok());
  CHECK_FALSE(built_in.value().properties.has_rotation);
  CHECK_FALSE(session::find_description("desk4d", {}).ok());
  const auto file = session::find_description("desk4d", TACTUS_SOURCE_DIR "/hal/devices/virtuose6d.toml");
  INFO(file.message());
  REQUIRE(file.ok());
  CHECK(file.value().properties.has_rotation);
  CHECK_FALSE(session::find_description("desk3d", "/nowhere.toml").ok());
}

TEST_CASE("a real-time run on a device behind a link counts every tick and names the link's figures in JSON") {
  LinkedRun linked;
  linked.session->options.duration_s = 0.3;
  std::atomic<bool> stop{false};
  const auto summary = session::run_realtime(*linked.session, {}, stop);
  INFO(summary.message());
  REQUIRE(summary.ok());
  CHECK(summary.value().stats.ticks == 300);
  REQUIRE(summary.value().link.has_value());
  CHECK(summary.value().link->reads.fresh == 300);
  CHECK(summary.value().link->force_age.count() == 300);
}
