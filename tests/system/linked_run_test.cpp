// A whole run on a device behind a link: the same frames as on a cable, the firmware at the other end in this process.
#include "hal/classes/on_link.h"
#include "hal/loopback_link.h"
#include "tests/support/temporary_file.h"
#include "tests/system/session_bench.h"
#include "tools/session/find_description.h"
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
    auto same_device = hal::remember_device(*link);
    REQUIRE(same_device.ok());
    hardware.same_device = std::move(same_device).value();
    hardware.device = std::make_unique<hal::AnyDevice>(std::make_unique<Device>(profile, kPeriod_ns, std::move(link)));
    hardware.identity = "a link in this process";
    session::RunOptions options;
    options.device = "usb";
    options.priority = 0;
    options.duration_s = 2;
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

TEST_CASE("a real-time run leaves its device in IDLE without fault, ended by its duration or stopped under force",
          "[threads]") {
  const bool stopped = GENERATE(false, true);
  LinkedRun linked;
  linked.session->options.duration_s = stopped ? 30 : 1.5;
  std::atomic<bool> stop{false};
  session::RealtimeHooks hooks;
  double most_N = 0;
  hooks.show = [&](const session::LiveStatus& live, double) {
    most_N = std::max(most_N, live.force_N.load());
    if (stopped && most_N > 1.0) stop.store(true);
    return true;
  };
  const auto summary = session::run_realtime(*linked.session, hooks, stop);
  INFO(summary.message());
  REQUIRE(summary.ok());
  CHECK(most_N > 1.0);
  CHECK(summary.value().stats.fault_count == 0);
  const firmware::Controller& device = linked.loopback->device().controller();
  CHECK(device.state() == firmware::State::kIdle);
  CHECK(device.fault() == firmware::Fault::kNone);
  // It gets no more commands, and stays in this state.
  std::array<std::byte, firmware::kMaxFrameSize> buffer{};
  for (int i = 0; i < 50; ++i) (void)linked.loopback->receive(buffer);
  CHECK(device.state() == firmware::State::kIdle);
  CHECK(device.fault() == firmware::Fault::kNone);
}

TEST_CASE("a device whose register changed in a run is not armed again, and why is said once", "[threads]") {
  LinkedRun linked;
  linked.session->options.duration_s = 30;
  std::atomic<bool> stop{false};
  std::atomic<std::uint32_t> requests{0};
  std::vector<std::string> said;
  session::RealtimeHooks hooks;
  hooks.requests = &requests;
  hooks.say = [&](const std::string& line) { said.push_back(line); };
  enum { kPressing, kDisarming, kArming } phase = kPressing;
  int looks_after = 0;
  double most_after_N = 0;
  hooks.show = [&](const session::LiveStatus& live, double) {
    const firmware::ServiceMessage limitless{.operation = firmware::Operation::kWrite,
                                             .status = firmware::ServiceStatus::kGood,
                                             .tag = 1,
                                             .address = firmware::number::kMaxForce,
                                             .value = std::bit_cast<std::uint32_t>(1e6f)};
    if (phase == kPressing && live.force_N.load() > 1.0) {
      phase = kDisarming;
      requests.fetch_or(loop::kDisarm);
    } else if (phase == kDisarming) {  // a register is written outside FORCE alone
      const auto reply = linked.loopback->call(limitless, {});
      if (reply.ok() && reply.value().status == firmware::ServiceStatus::kGood) phase = kArming;
    } else if (phase == kArming) {
      most_after_N = std::max(most_after_N, live.force_N.load());
      requests.fetch_or(loop::kArm);
      if (!said.empty()) ++looks_after;
    }
    return looks_after < 4;
  };
  const auto summary = session::run_realtime(*linked.session, hooks, stop);
  INFO(summary.message());
  REQUIRE(summary.ok());
  CHECK(phase == kArming);
  CHECK(most_after_N == 0.0);
  REQUIRE(summary.value().arm_refusals.size() == 1);
  CHECK_THAT(summary.value().arm_refusals[0], Contains("its max_force (register 0x0130) is 1000000, this run began"));
  REQUIRE(said.size() == 1);
  CHECK(said[0] == "not armed: " + summary.value().arm_refusals[0]);
  CHECK_THAT(to_text(summary.value()), Contains("not armed") && Contains("max_force"));
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

TEST_CASE("a real-time run on a device behind a link counts every tick and names the link's figures in JSON",
          "[threads]") {
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
