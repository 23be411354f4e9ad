// The suite for devices without tactus' wire: good on the ones that there are, bad on one that does not obey.
#include <atomic>
#include <catch2/catch.hpp>
#include <thread>

#include "hal/device_class.h"
#include "tools/hil/device_suite.h"
#include "tools/session/find_description.h"

using namespace tactus;
using haptics::DeviceState;

namespace {

hil::HilOptions stepped() {
  hil::HilOptions options;
  options.stepped = true;
  options.force_N = 1;
  return options;
}

hal::OpenedDevice open(const char* name, const char* file) {
  const auto profile = session::find_description("desk3d", std::string(TACTUS_SOURCE_DIR "/hal/devices/") + file);
  INFO(profile.message());
  REQUIRE(profile.ok());
  auto opened = hal::find_device_class(name)->open({{}, profile.value(), 1'000'000, {}, {}});
  INFO(opened.message());
  REQUIRE(opened.ok());
  return std::move(opened).value();
}

hil::SuiteReport run(hal::OpenedDevice& opened, bool motors_allowed = true) {
  hil::DeviceUnderTest under_test{*opened.device, opened.identity, stepped()};
  return run_device_suite(under_test, {{}, motors_allowed}, {});
}

const hil::CheckReport& check_of(const hil::SuiteReport& report, std::string_view name) {
  for (const hil::CheckReport& one : report.checks)
    if (name == one.check->name) return one;
  FAIL("no such check");
  return report.checks.front();
}

// Stays in FORCE whatever is commanded, and reports it.
struct Disobedient {
  haptics::DeviceProperties device_properties;
  haptics::DeviceSample sample;
  const haptics::DeviceProperties& properties() const noexcept { return device_properties; }
  void read(haptics::DeviceInput& input) noexcept {
    ++sample.sequence;
    sample.state = DeviceState::kForce;
    input = {haptics::ReadStatus::kFresh, 0, sample};
  }
  void write(const haptics::DeviceCommand& command) noexcept { sample.echoed_sequence = command.sequence; }
};

// Obeys, and sends no more samples after the first command with a force.
struct Mute {
  haptics::DeviceProperties device_properties;
  haptics::DeviceSample sample;
  bool silent{false};
  unsigned pushed{0};  // commands with a force, since it is silent
  DeviceState last_wanted{DeviceState::kIdle};
  const haptics::DeviceProperties& properties() const noexcept { return device_properties; }
  void read(haptics::DeviceInput& input) noexcept {
    sample.sequence += silent ? 0 : 1;
    input = {silent ? haptics::ReadStatus::kMissing : haptics::ReadStatus::kFresh, 0, sample};
  }
  void write(const haptics::DeviceCommand& command) noexcept {
    last_wanted = command.wanted;
    pushed += silent && norm(command.wrench.force) > 0;
    silent = silent || norm(command.wrench.force) > 0;
    if (silent) return;
    sample.state = command.wanted;
    sample.echoed_sequence = command.sequence;
  }
};

}  // namespace

TEST_CASE("hil: a device without samples while it is pushed gets no force after ten periods, and is left in BRAKE") {
  auto mute = std::make_unique<Mute>();
  const Mute& truth = *mute;
  hal::OpenedDevice opened{std::make_unique<hal::AnyDevice>(std::move(mute)), "mute", {}};
  hil::DeviceUnderTest under_test{*opened.device, opened.identity, stepped(), {}, [] { return "it is mute"; }};
  const hil::SuiteReport report = run_device_suite(under_test, {{"force"}, true}, {});
  CHECK(truth.silent);
  CHECK(truth.pushed <= 10);
  CHECK(truth.last_wanted == DeviceState::kBrake);
  const hil::CheckFinding& finding = check_of(report, "force").finding;
  CHECK(finding.verdict == hil::CheckVerdict::kBad);
  CHECK_THAT(finding.reason, Catch::Contains("ten periods in a row without a sample") && Catch::Contains("it is mute"));
  CHECK_THAT(report.left_in, Catch::Contains("it is mute"));
}

TEST_CASE("hil: in real time the exchange goes on between two checks, without force and as it was wanted",
          "[threads]") {
  struct Counted {
    haptics::DeviceProperties device_properties;
    haptics::DeviceSample sample;
    std::atomic<unsigned> writes{0};
    std::atomic<double> force_N{0};
    const haptics::DeviceProperties& properties() const noexcept { return device_properties; }
    void read(haptics::DeviceInput& input) noexcept {
      ++sample.sequence;
      input = {haptics::ReadStatus::kFresh, 0, sample};
    }
    void write(const haptics::DeviceCommand& command) noexcept {
      sample.state = command.wanted;
      sample.echoed_sequence = command.sequence;
      force_N = norm(command.wrench.force);
      ++writes;
    }
  };
  auto counted = std::make_unique<Counted>();
  const Counted& truth = *counted;
  hal::OpenedDevice opened{std::make_unique<hal::AnyDevice>(std::move(counted)), "counted", {}};
  hil::HilOptions options;
  options.setup.priority = 0;
  options.setup.lock_memory = false;
  hil::DeviceUnderTest under_test{*opened.device, opened.identity, options};
  unsigned went_on = 0;
  hil::SuiteHooks hooks;
  hooks.progress = [&](const hil::Check&, double) {
    const unsigned before = truth.writes;
    for (int i = 0; i < 20'000 && truth.writes < before + 5; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    went_on += truth.writes >= before + 5 && truth.force_N == 0;
  };
  const hil::SuiteReport report = run_device_suite(under_test, {{"identity", "enable"}, true}, hooks);
  CHECK(went_on == 2);
  CHECK(report.good());
  CHECK(report.real_time);
  CHECK(report.left_in == "IDLE");
}

TEST_CASE("hil: an arm of drives on simulated drives is good in every check, and so is the template") {
  for (const auto& [name, file] : {std::pair{"drives-sim", "point_arm_drives.toml"},
                                   {"drives-sim", "wristed_arm_moteus.toml"},
                                   {"falcon-sim", "desk3d.toml"},
                                   {"example", "desk3d.toml"}}) {
    CAPTURE(name, file);
    hal::OpenedDevice opened = open(name, file);
    const hil::SuiteReport report = run(opened);
    for (const hil::CheckReport& one : report.checks) {
      INFO(to_line(one));
      CHECK(one.finding.verdict == hil::CheckVerdict::kGood);
    }
    CHECK(report.checks.size() == hil::device_checks().size());
  }
}

TEST_CASE("hil: without the operator's consent no check enables a drive") {
  hal::OpenedDevice opened = open("drives-sim", "point_arm_drives.toml");
  const hil::SuiteReport report = run(opened, false);
  for (const hil::CheckReport& one : report.checks)
    CHECK(one.finding.verdict ==
          ((one.check->needs & hil::kMotors) != 0 ? hil::CheckVerdict::kSkipped : hil::CheckVerdict::kGood));
}

TEST_CASE("hil: a device that keeps its force is bad in every check that wants it to end") {
  hal::OpenedDevice opened{std::make_unique<hal::AnyDevice>(std::make_unique<Disobedient>()), "disobedient", {}};
  const hil::SuiteReport report = run(opened);
  CHECK_FALSE(report.good());
  for (const char* name : {"enable", "brake", "not-finite", "watchdog"})
    CHECK(check_of(report, name).finding.verdict == hil::CheckVerdict::kBad);
}
