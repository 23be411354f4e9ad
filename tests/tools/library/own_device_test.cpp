// A device of the caller's own: what it is told, and what its mistakes become.
#include "tests/support/temporary_file.h"
#include "tests/system/session_bench.h"
#include "tests/tools/library/library_bench.h"

using namespace tactus;
using namespace tactus::test;
using Catch::Matchers::Contains;

namespace {

// A hand of 300 N/m that goes from 5 mm above the middle to 16 mm below it in half a second, and stays: kPressScene's.
class Puck final : public Device {
 public:
  DeviceProperties properties_now;
  Reading reading{Reading::kFresh};
  DeviceSample sample;
  Error start_error;
  std::vector<DeviceCommand> commands;
  int starts{0}, stops{0};
  double period_s{0}, position_m{-0.005}, velocity_m_per_s{0}, time_s{0};

  DeviceProperties properties() const override { return properties_now; }
  Error start(double period) override {
    ++starts;
    period_s = period;
    position_m = -0.005;
    velocity_m_per_s = time_s = 0;
    return start_error;
  }
  Reading read(DeviceSample& out) noexcept override {
    const double target_m = -0.005 - 0.011 * std::min(1.0, time_s / 0.5);
    const double force_N = commands.empty() ? 0 : commands.back().force_N[2];
    velocity_m_per_s += period_s / 0.3 * (300 * (target_m - position_m) - 20 * velocity_m_per_s + force_N);
    position_m += period_s * velocity_m_per_s;
    time_s += period_s;
    sample.position_m = {0, 0, position_m};
    out = sample;
    return reading;
  }
  void write(const DeviceCommand& command) noexcept override { commands.push_back(command); }
  void stop() noexcept override { ++stops; }
};

Scene press_scene() {
  Scene scene;
  REQUIRE_FALSE(scene.parse(kPressScene, "press"));
  return scene;
}

}  // namespace

TEST_CASE("a device of one's own feels the block, and gives the same bits twice") {
  std::uint64_t hash = 0;
  for (int trial = 0; trial < 2; ++trial) {
    Puck puck;
    puck.sample.buttons = 5;
    Session session;
    const Error error = session.open(press_scene(), {}, puck);
    INFO(error.message());
    REQUIRE_FALSE(error);
    step(session, 2000);
    CHECK(session.last().has(Condition::kProxyContact));
    CHECK(session.last().force_N[2] > 0.5);
    CHECK(session.last().fault == FaultCode::kNone);
    CHECK(session.last().buttons == 5);
    CHECK(session.last().tool_position_m[2] == puck.position_m);
    CHECK(puck.commands.size() == 2000);
    CHECK(puck.commands.back().force_on);
    CHECK(puck.commands.back().force_N == session.last().force_N);
    // The hand's spring balances the device's force.
    CHECK(puck.commands.back().force_N[2] == Approx(300 * (puck.position_m + 0.016)).epsilon(0.05));
    CHECK_THAT(session.summary().json, Contains("\"device\": \"own\""));
    if (trial == 1) CHECK(session.state_hash() == hash);
    hash = session.state_hash();
    CHECK(puck.starts == 1);
    REQUIRE_FALSE(session.close());
    CHECK(puck.stops == 1);
    CHECK_FALSE(puck.commands.back().force_on);
    CHECK(puck.commands.back().force_N == Vector3{});
  }
}

TEST_CASE("a tape of a device of one's own replays without it") {
  const TemporaryFile tape;
  Puck puck;
  Session session;
  REQUIRE_FALSE(session.open(press_scene(), {}, puck));
  REQUIRE_FALSE(session.record(tape.path()));
  step(session, 1500);
  REQUIRE_FALSE(session.close());
  Replay replay;
  const Error error = replay_tape(tape.path(), replay);
  INFO(error.message());
  REQUIRE_FALSE(error);
  CHECK(replay.same_bits);
  CHECK(replay.compared == 1500);
}

TEST_CASE("reset restarts a device") {
  Puck puck;
  Session session;
  REQUIRE_FALSE(session.open(press_scene(), {}, puck));
  step(session, 800);
  const std::uint64_t hash = session.state_hash();
  puck.commands.clear();
  REQUIRE_FALSE(session.reset());
  CHECK(puck.stops == 1);
  puck.commands.clear();
  step(session, 800);
  CHECK(puck.starts == 2);
  CHECK(session.state_hash() == hash);
}

TEST_CASE("what a device gets wrong is a fault by its name, the force goes, and a re-arm brings it back") {
  Puck puck;
  Session session;
  REQUIRE_FALSE(session.open(press_scene(), {}, puck));
  step(session, 1000);
  REQUIRE(session.last().fault == FaultCode::kNone);
  const auto expect = [&](FaultCode fault) {
    step(session, 60);
    CHECK(session.last().fault == fault);
    CHECK(session.last().force_N == Vector3{});
    CHECK_FALSE(puck.commands.back().force_on);
    CHECK(puck.commands.back().brake);
    puck.reading = Reading::kFresh;
    puck.sample = {};
    session.request(Request::kRearm);
    std::size_t clears = 0;
    const std::size_t before = puck.commands.size();
    step(session, 600);
    for (std::size_t i = before; i < puck.commands.size(); ++i) clears += puck.commands[i].clear_fault ? 1 : 0;
    CHECK(clears == 1);
    CHECK(session.last().fault == FaultCode::kNone);
    CHECK(puck.commands.back().force_on);
  };
  SECTION("no samples") {
    puck.reading = Reading::kMissing;
    expect(FaultCode::kLinkLost);
  }
  SECTION("gone") {
    puck.reading = Reading::kDisconnected;
    expect(FaultCode::kDeviceUnplugged);
  }
  SECTION("a fault of its own") {
    puck.sample.fault = 9;
    step(session, 2);
    CHECK(session.last().device_fault == 9);
    expect(FaultCode::kDeviceFault);
  }
  SECTION("a fault of its own, beyond the numbers for it") {
    puck.sample.fault = 0x80000029;  // with the bit of tactus' own: axis 1 of an arm of drives
    step(session, 2);
    CHECK(session.last().device_fault == 0x7fffffff);
    expect(FaultCode::kDeviceFault);
  }
  SECTION("no rotation") {
    puck.sample.rotation = {0, 0, 0, 0};
    expect(FaultCode::kInputRotation);
  }
  SECTION("no number") {
    puck.sample.rotation = {std::nan(""), 0, 0, 0};
    expect(FaultCode::kInputNotFinite);
  }
}

TEST_CASE("a device that cannot be is refused, by the figure and what is accepted") {
  const auto said = [](auto&& change, const Options& options = {}) {
    Puck puck;
    change(puck);
    Session session;
    const Error error = session.open(press_scene(), options, puck);
    CHECK(error.kind() == Error::Kind::kOption);
    CHECK(puck.starts == 0);
    return error.message();
  };
  CHECK_THAT(said([](Puck& p) { p.properties_now.max_force_N = 0; }),
             Contains("max_force_N is 0; accepted: a number > 0"));
  CHECK_THAT(said([](Puck& p) { p.properties_now.mass_kg = std::nan(""); }), Contains("mass_kg"));
  CHECK_THAT(said([](Puck& p) { p.properties_now.delay_s = -1; }), Contains("delay_s is -1; accepted: a number >= 0"));
  CHECK_THAT(said([](Puck& p) { p.properties_now.continuous_force_N = 99; }), Contains("no more than at most"));
  // Gains of the scene that such a coarse and slow device cannot hold.
  CHECK_THAT(said([](Puck& p) { p.properties_now.delay_s = 0.05; }),
             Contains("is not stable at 1000 Hz on this device"));
  Options usb;
  usb.device = "usb";
  usb.real_time = true;
  CHECK_THAT(said([](Puck&) {}, usb), Contains("beside a Device"));
  Options inject;
  inject.inject = "lost@100+5";
  CHECK_THAT(said([](Puck&) {}, inject), Contains("faults of the device are for the simulated one"));
}

TEST_CASE("a device that does not start ends the first step with its own words") {
  Puck puck;
  puck.start_error = {Error::Kind::kMachine, "no power: switch it on"};
  Session session;
  REQUIRE_FALSE(session.open(press_scene(), {}, puck));
  const Error error = session.step(1);
  CHECK(error.kind() == Error::Kind::kMachine);
  CHECK_THAT(error.message(), Contains("no power: switch it on"));
  CHECK(session.ticks_done() == 0);
  REQUIRE_FALSE(session.close());
  CHECK(puck.stops == 0);
}
