#include "hal/simulated_device.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <string>

#include "tests/support/rt_guard.h"
#include "tests/support/skip.h"

using namespace tactus;
using namespace tactus::hal;
using haptics::DeviceCommand;
using haptics::DeviceInput;
using haptics::DeviceState;
using haptics::ReadStatus;

namespace {

constexpr std::int64_t kPeriod_ns = 1'000'000;

const std::vector<HandWaypoint> kWave{{0.0, {}, {}},
                                      {0.4, {0.05, -0.03, 0.02}, {0.2, -0.4, 0.3}},
                                      {0.8, {-0.04, 0.02, -0.03}, {-0.3, 0.5, 0.1}},
                                      {1.2, {}, {}}};

HandModel waving_hand() {
  HandParameters p;
  p.repeat = true;
  return {p, kWave};
}

constexpr std::uint64_t kFirstSequence = 12;  // the firmware has run while it was told to be IDLE

// A device and a host that answers every sample with the same wrench.
struct Rig {
  std::string name;
  SimulatedDevice device;
  DeviceInput input;
  DeviceCommand command;

  explicit Rig(const SimulationOptions& options = {}, std::string_view profile = "virtuose6d", HandModel hand = {})
      : name(profile), device(*find_profile(profile), std::move(hand), options) {
    command.wanted = DeviceState::kForce;
  }
  Rig(const std::string& faults, unsigned delay_ticks = 1, HandModel hand = waving_hand())
      : Rig(with(faults, delay_ticks), "virtuose6d", std::move(hand)) {}

  static SimulationOptions with(const std::string& faults, unsigned delay_ticks) {
    SimulationOptions o;
    o.transport_delay_ticks = delay_ticks;
    const auto script = parse_fault_script(faults);
    INFO(script.message());
    REQUIRE(script.ok());
    o.faults = script.value();
    return o;
  }
  ReadStatus tick() {
    device.read(input);
    ++command.sequence;
    device.write(command);
    return input.status;
  }
  void ticks(int n) {
    for (int i = 0; i < n; ++i) tick();
  }
  // Ticks until read number `n` (from 0) is done.
  void until(std::uint64_t n) {
    while (device.tick() < n || command.sequence == 0) tick();
  }
  // Force of the motors at the tool.
  Vec3d force() const {
    AxisVector effort{};
    for (unsigned i = 0; i < kAxisCount; ++i) effort[i] = static_cast<double>(device.motor_outputs().effort[i]);
    return profile().kinematics.wrench_of(device.plant().coordinates(), effort).force;
  }
  // A force differs from the command by the samples' quanta, the effort's 24 bits and the tool's motion in a step.
  bool pushes(double force_N) const { return std::abs(force().x - force_N) < 1e-3 * std::abs(force_N); }
  bool is_limp() const { return device.motor_outputs().effort == firmware::AxisValues{}; }
  const DeviceProfile& profile() const { return *find_profile(name); }
  // The tick in which the sample was taken, by the device's clock.
  std::uint64_t sampled_at() const { return input.sample.device_time_ns / static_cast<std::uint64_t>(kPeriod_ns); }
};

// For the read of each tick in [from, to]: the tick of its sample, or a letter if there was no fresh sample.
std::string story(Rig& rig, std::uint64_t from, std::uint64_t to) {
  rig.until(from - 1);
  std::string text;
  for (std::uint64_t t = from; t <= to; ++t) {
    const ReadStatus status = rig.tick();
    text += text.empty() ? "" : " ";
    text += status == ReadStatus::kFresh     ? std::to_string(rig.sampled_at())
            : status == ReadStatus::kMissing ? "missing"
            : status == ReadStatus::kCorrupt ? "corrupt"
                                             : "gone";
  }
  return text;
}

}  // namespace

TEST_CASE("the delay from a sample to the effort that answers it is exactly the requested one") {
  for (const unsigned delay : {1u, 2u, 3u, 4u, 5u, 8u, 32u}) {
    Rig rig("", delay, HandModel());
    CHECK(rig.device.properties().delay_s == Approx(1e-3 * delay));
    rig.ticks(100);
    REQUIRE(rig.device.controller().state() == firmware::State::kForce);
    const std::uint64_t state_age = rig.device.tick() - rig.sampled_at();
    CHECK(state_age == (delay - 1) / 2);
    rig.tick();
    const std::uint64_t sampled = rig.sampled_at() + 1;  // the sample that the next read brings
    rig.command.wrench.force.x = 2.5;
    rig.tick();
    while (!rig.pushes(2.5)) rig.tick();
    CHECK(rig.device.tick() - sampled == delay);
    CHECK(rig.input.sample.echoed_sequence <= rig.command.sequence);
  }
}

TEST_CASE("the profile's delay holds unless another is given") {
  SimulationOptions options;
  options.period_ns = 250'000;
  const Rig rig(options);
  CHECK(rig.device.properties().delay_s == Approx(250e-6));
}

TEST_CASE("a sample is the true pose to within half a quantum along every direction of the frame") {
  for (const char* profile : {"virtuose6d", "desk3d"}) {
    Rig rig(SimulationOptions{}, profile, waving_hand());
    const haptics::DeviceProperties& p = rig.device.properties();
    double largest = 0;
    for (int i = 0; i < 3000; ++i) {
      REQUIRE(rig.tick() == ReadStatus::kFresh);
      const Posed truth = rig.device.plant().pose(), told = rig.input.sample.device_from_tool;
      const Vec3d turned = small_rotation_vector(told.rotation * conjugate(truth.rotation));
      for (int k = 0; k < 3; ++k) {
        REQUIRE(std::abs(told.position[k] - truth.position[k]) <= 0.5 * p.position_quantum_m);
        REQUIRE(std::abs(turned[k]) <= 0.5 * p.rotation_quantum_rad);
      }
      largest = std::max(largest, norm(truth.position));
      REQUIRE(norm(told.rotation) == Approx(1.0).epsilon(1e-14));
    }
    CHECK(largest > 0.03);
  }
}

TEST_CASE("the device starts idle, gives force on request, and numbers its samples from the first read") {
  Rig rig;
  rig.command.wanted = DeviceState::kIdle;
  for (std::uint64_t t = 0; t < 10; ++t) {
    REQUIRE(rig.tick() == ReadStatus::kFresh);
    CHECK(rig.input.sample.sequence == t + kFirstSequence);
    CHECK(rig.sampled_at() == t);
    CHECK(rig.input.sample.state == DeviceState::kIdle);
    CHECK(rig.input.sample.echoed_sequence == t);
  }
  rig.command.wanted = DeviceState::kForce;
  rig.ticks(2);
  CHECK(rig.input.sample.state == DeviceState::kForce);
}

TEST_CASE("a wrench that the host sends is the wrench that acts on the tool") {
  Rig rig("", 1, waving_hand());
  rig.ticks(3);
  rig.command.wrench = {{3, -2, 1}, {0.2, -0.1, 0.3}};
  for (int i = 0; i < 1000; ++i) {
    rig.tick();
    if (i < 3) continue;
    const Wrenchd motor = rig.device.plant().motor_wrench();
    // The arm's axes turned by less than 2 mrad since the sample that the efforts are for, the wrist's by less than
    // 10 mrad, and its pitch is moderate.
    REQUIRE(norm(motor.force - rig.command.wrench.force) < 0.02);
    REQUIRE(norm(motor.torque - rig.command.wrench.torque) < 0.02);
  }
}

TEST_CASE("the energy balance of a whole run is complete") {
  Rig rig("", 1, waving_hand());
  for (int i = 0; i < 3000; ++i) {
    rig.command.wrench.force = {std::sin(i * 0.01) * 5, 2, 0};
    rig.command.wrench.torque = {0, 0.05, 0};
    rig.tick();
    const PlantWork& b = rig.device.plant().work();
    REQUIRE(rig.device.plant().kinetic_energy_J() ==
            Approx(b.motors + b.hand + b.viscous + b.coulomb + b.stops).margin(1e-9));
  }
  CHECK(rig.device.plant().work().motors != 0.0);
}

TEST_CASE("a desk device feels no torque and reports none of it") {
  Rig rig(SimulationOptions{}, "desk3d", waving_hand());
  rig.command.wrench = {{1, 2, 3}, {5, 5, 5}};
  rig.ticks(200);
  CHECK(rig.device.controller().state() == firmware::State::kForce);
  CHECK(rig.input.sample.device_from_tool.rotation == Quatd{});
  CHECK(norm(rig.force() - Vec3d{1, 2, 3}) < 0.01);
  for (unsigned i = 3; i < kAxisCount; ++i) CHECK(rig.device.motor_outputs().effort[i] == 0.0f);
  CHECK(rig.input.sample.limits == 0);
}

TEST_CASE("lost frames are missing, and the ones after are there") {
  Rig state("lost/state@100+3");
  CHECK(story(state, 98, 104) == "98 99 missing missing missing 103 104");
  Rig command("lost/command@100+3");
  CHECK(story(command, 98, 104) == "98 99 100 101 102 103 104");
  CHECK(command.device.controller().state() == firmware::State::kForce);
}

TEST_CASE("lost commands are missed one by one and brake at the tenth") {
  Rig nine("lost/command@100+9"), ten("lost/command@100+10");
  for (std::uint64_t t = 0; t <= 112; ++t) {
    nine.tick();
    ten.tick();
    // The command written in tick t is seen in t + 1: tick 100's is missed in 101.
    const std::uint64_t missed = t < 101 ? 0 : std::min<std::uint64_t>(t - 100, 10);
    if (t > 1 && t <= 109) CHECK(nine.device.controller().missed_commands() == missed);
    CHECK((ten.device.controller().state() == firmware::State::kBrake) == (t >= 110));
  }
  CHECK(nine.device.controller().state() == firmware::State::kForce);
  CHECK(ten.device.controller().fault() == firmware::Fault::kCommandsLost);
  CHECK(ten.input.sample.state == DeviceState::kBrake);
  CHECK(ten.input.sample.device_fault == 1);
}

TEST_CASE("late frames come later, and a newer one that is there hides them") {
  Rig burst("late/state@100+5:2");
  CHECK(story(burst, 98, 108) == "98 99 missing missing 100 101 102 105 106 107 108");
  Rig single("late/state@100:2");
  CHECK(story(single, 98, 103) == "98 99 missing 101 102 103");
  Rig overtaken("late/state@100:2,lost/state@102");  // an old frame comes after a newer one
  CHECK(story(overtaken, 98, 104) == "98 99 missing 101 100 103 104");
  CHECK(overtaken.input.sample.sequence == 104 + kFirstSequence);
  Rig command("late/command@100+12:3");
  command.until(103);
  CHECK(command.device.controller().missed_commands() == 3);
  command.tick();
  CHECK(command.device.controller().missed_commands() == 0);
}

TEST_CASE("duplicated frames repeat the one before and feed no watchdog") {
  Rig state("duplicated/state@100+3");
  CHECK(story(state, 98, 104) == "98 99 99 99 99 103 104");
  Rig command("duplicated/command@100+10");
  command.until(110);
  CHECK(command.device.controller().state() == firmware::State::kBrake);
  CHECK(command.device.controller().refused_frames() == 10);
}

TEST_CASE("corrupted frames fail their check at either end") {
  for (const int bits : {1, 2, 3, 4, 5}) {
    Rig state("corrupted/state@100+50:" + std::to_string(bits));
    state.until(99);
    for (int i = 0; i < 50; ++i) REQUIRE(state.tick() == ReadStatus::kCorrupt);
    CHECK(state.sampled_at() == 99);  // the last one that came
    CHECK(state.tick() == ReadStatus::kFresh);
    Rig command("corrupted/command@100+10:" + std::to_string(bits));
    command.until(110);
    CHECK(command.device.controller().state() == firmware::State::kBrake);
    CHECK(command.device.controller().refused_frames() == 10);
  }
}

TEST_CASE("nan reaches the host as fresh samples that are not finite, and the firmware as a fault") {
  Rig state("nan@100+2");
  state.until(99);
  CHECK(is_finite(state.input.sample.device_from_tool));
  for (int i = 0; i < 2; ++i) {
    CHECK(state.tick() == ReadStatus::kFresh);
    CHECK(std::isnan(state.input.sample.device_from_tool.position.x));
    CHECK(std::isnan(state.input.sample.device_from_tool.rotation.w));
  }
  state.tick();
  CHECK(is_finite(state.input.sample.device_from_tool));
  CHECK(state.device.controller().state() == firmware::State::kForce);
  Rig command("nan/command@100");
  command.until(100);
  CHECK(command.device.controller().state() == firmware::State::kForce);
  command.tick();
  CHECK(command.device.controller().fault() == firmware::Fault::kEffortNotFinite);
  CHECK(command.is_limp());
}

TEST_CASE("random counts are finite, far away, and in frames with a valid checksum") {
  Rig rig("wild@100+20");
  rig.until(99);
  double largest = 0;
  for (int i = 0; i < 20; ++i) {
    CHECK(rig.tick() == ReadStatus::kFresh);
    CHECK(is_finite(rig.input.sample.device_from_tool));
    largest = std::max(largest, norm(rig.input.sample.device_from_tool.position));
  }
  CHECK(largest > 2 * rig.device.properties().workspace_radius_m);
  rig.tick();
  CHECK(norm(rig.input.sample.device_from_tool.position) < rig.device.properties().workspace_radius_m);
  CHECK(rig.device.controller().state() == firmware::State::kForce);
}

TEST_CASE("teleport turns the sample's first axis by the given way and leaves the tool where it is") {
  Rig rig("teleport@100+2:0.3");
  const double forearm_m = rig.profile().description.links.forearm_m;
  for (std::uint64_t t = 0; t < 105; ++t) {
    rig.tick();
    // About the column, that is by 0.3 m at the centre.
    const bool jumped = t == 100 || t == 101;
    const Vec3d column{-forearm_m, 0, 0}, truth = rig.device.plant().pose().position;
    const Quatd turn = quat_from_rotation_vector(Vec3d{0, 0, jumped ? 0.3 / forearm_m : 0.0});
    const Vec3d off = rig.input.sample.device_from_tool.position - (column + rotate(turn, truth - column));
    REQUIRE(norm(off) < 2 * rig.device.properties().position_quantum_m);
  }
  CHECK(rig.device.controller().state() == firmware::State::kForce);
}

TEST_CASE("a frozen device repeats its frame, gives no effort, and goes on from there") {
  Rig rig("frozen@100+30");
  rig.command.wrench.force.x = 2;
  rig.until(99);
  CHECK(rig.pushes(2.0));
  const std::uint64_t sequence = rig.input.sample.sequence;
  for (int i = 0; i < 30; ++i) {
    CHECK(rig.tick() == ReadStatus::kFresh);
    REQUIRE(rig.input.sample.sequence == sequence);
    REQUIRE(rig.sampled_at() == 99);
    REQUIRE(rig.is_limp());
  }
  rig.tick();
  CHECK(rig.sampled_at() == 130);
  CHECK(rig.input.sample.sequence == sequence + 1);
  CHECK(rig.pushes(2.0));
}

TEST_CASE("an unplugged device is gone at once, brakes by itself, and is back when plugged in") {
  Rig rig("unplugged@100+50", 3);
  rig.command.wrench.force.x = 2;
  rig.until(99);
  for (int i = 0; i < 50; ++i) {
    REQUIRE(rig.tick() == ReadStatus::kDisconnected);
    REQUIRE(rig.sampled_at() == 98);
  }
  CHECK(rig.device.controller().state() == firmware::State::kBrake);
  CHECK(rig.is_limp());
  CHECK(rig.tick() == ReadStatus::kMissing);  // the first new frame is under way: one tick of the three
  CHECK(rig.tick() == ReadStatus::kFresh);
  CHECK(rig.sampled_at() == 150);
  CHECK(rig.input.sample.state == DeviceState::kBrake);
  rig.ticks(5);
  rig.command.rearm = 1;
  rig.tick();
  rig.command.rearm = 0;
  rig.ticks(6);
  CHECK(rig.input.sample.state == DeviceState::kForce);
  CHECK(rig.pushes(2.0));
}

TEST_CASE("what was under way when the device was unplugged is gone") {
  Rig rig("late/state@99:60,unplugged@100+50,lost/state@159", 3);  // frame 99 would come into the gap of 159
  CHECK(story(rig, 157, 162) == "156 157 158 missing 160 161");
}

TEST_CASE("the e-stop line cuts the effort in its own tick and latches") {
  Rig rig("estop@100+5");
  rig.command.wrench.force.x = 2;
  rig.until(99);
  CHECK(rig.pushes(2.0));
  rig.tick();
  CHECK(rig.is_limp());
  CHECK(rig.input.sample.state == DeviceState::kBrake);
  CHECK(rig.input.sample.device_fault == static_cast<unsigned>(firmware::Fault::kEmergencyStop));
  CHECK((rig.input.sample.limits & firmware::bit_of(firmware::Limit::kEmergencyStop)) != 0);
  rig.ticks(50);
  CHECK(rig.input.sample.state == DeviceState::kBrake);
  CHECK((rig.input.sample.limits & firmware::bit_of(firmware::Limit::kEmergencyStop)) == 0);
}

TEST_CASE("whatever the faults, the efforts stay within the profile's limits") {
  Rig rig(
      "wild@50+50,teleport@120+50:0.2,late@200+50:7,corrupted@300+5,duplicated@320+5,lost@400+9,frozen@450+20,"
      "nan@500+5",
      2);
  rig.command.wrench = {{500, -300, 1e30}, {90, 1e200, -3}};
  const DeviceProfile& p = *find_profile("virtuose6d");
  for (int i = 0; i < 600; ++i) {
    rig.tick();
    const auto& e = rig.device.motor_outputs().effort;
    REQUIRE(std::hypot(e[0], e[1], e[2]) <= 1.0101f * static_cast<float>(p.bounds.arm_effort_norm));
    for (unsigned k = 0; k < 6; ++k) REQUIRE(std::abs(e[k]) <= 1.0101f * static_cast<float>(p.bounds.effort[k]));
  }
}

TEST_CASE("a pushing host and a holding hand come to rest at F / k, friction apart") {
  Rig rig(SimulationOptions{}, "virtuose6d", HandModel{});
  rig.command.wrench.force.x = 8;
  rig.ticks(3000);
  CHECK(rig.device.plant().pose().position.x == Approx(8.0 / 400).margin(0.2 / 400));
  CHECK(rig.device.plant().hand_wrench().force.x == Approx(-8.0).margin(0.2001));
}

TEST_CASE("two devices with the same arguments and commands give the same bits") {
  const std::string faults = "corrupted@100+50:2,wild@300+50,late@400+20:3";
  Rig a(faults, 2), b(faults, 2);
  for (int i = 0; i < 2000; ++i) {
    a.command.wrench = b.command.wrench = {{std::sin(0.01 * i), 1, 2}, {0.1, 0.2, -0.1}};
    a.tick();
    b.tick();
    REQUIRE(a.input.status == b.input.status);
    REQUIRE(a.input.sample.sequence == b.input.sample.sequence);
    REQUIRE(a.input.sample.device_from_tool == b.input.sample.device_from_tool);
    REQUIRE(a.device.plant().coordinates() == b.device.plant().coordinates());
  }
}

TEST_CASE("reading and writing neither allocate nor lock", "[no-asan][no-tsan]") {
  Rig rig(
      "lost@10+2,late@20+5:3,duplicated@40+2,corrupted@50+2,nan@60,wild@70+5,teleport@80:0.1,frozen@90+5,"
      "unplugged@200+20,estop@300+5");
  rig.tick();
  TACTUS_NEEDS(test::RtGuard::available(), "counting allocations needs a build without a sanitizer");
  const test::RtGuard guard;
  for (int i = 0; i < 5000; ++i) {
    rig.device.read(rig.input);
    ++rig.command.sequence;
    rig.device.write(rig.command);
  }
  CHECK(guard.allocations() == 0);
  CHECK(guard.frees() == 0);
  CHECK(guard.locks() == 0);
}

TEST_CASE("options out of their range are refused in one line") {
  const auto refused = [](auto&& spoil) {
    SimulationOptions o;
    spoil(o);
    return !SimulatedDevice::check(o).ok();
  };
  CHECK(SimulatedDevice::check({}).ok());
  CHECK(refused([](SimulationOptions& o) { o.period_ns = 0; }));
  CHECK(refused([](SimulationOptions& o) { o.period_ns = 2'000'000'000; }));
  CHECK(refused([](SimulationOptions& o) { o.sub_steps = 0; }));
  CHECK(refused([](SimulationOptions& o) { o.sub_steps = 65; }));
  CHECK(refused([](SimulationOptions& o) { o.transport_delay_ticks = 0; }));
  CHECK(refused([](SimulationOptions& o) { o.transport_delay_ticks = 33; }));
}
