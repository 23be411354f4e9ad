// The device's own image in QEMU, driven from outside: this program on the PC is its host, over the serial line, and
// its mechanics, in the memory that both share. Nothing in the image knows of a test.
//
// usage: image_test IMAGE MEMORY_FILE SYMBOL=ADDRESS...   The symbols: see kSymbols; addresses in hexadecimal.
// The device runs on QEMU's clock, this program on the PC's: so all that is checked is about the device's own frames,
// in their order, never about the time between them. Where the PC stood still for some periods, which the device's
// time stamps show, the scenario starts again. One line per scenario; exit status 0 if all are good.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include "firmware/boards/cortex_m/configuration.h"
#include "firmware/device.h"
#include "tests/firmware/boards/cortex_m/emulated/emulated_device.h"

using namespace tactus::firmware;
using namespace tactus::firmware::cortex_m;

namespace {

constexpr AxisValues kSmall{0.25f, 0.5f, -0.75f, 0, 0, 0}, kHuge{50.0f, -40.0f, 30.0f, 0, 0, 0};
constexpr int kManyFrames = 3000;

void to_idle(EmulatedDevice& d) {
  d.registers().pins = kPinStopReleased | kPinSupplyGood;
  const std::uint32_t before = d.commands_sent();  // some of them may still be on their way, and want FORCE
  for (int i = 0; i < kManyFrames; ++i) {
    const StateFrame s = d.turn(State::kIdle, {}, d.commands_sent() % 2 == 1);
    if (s.state == State::kIdle && is_newer(s.echoed_sequence, before)) return;
  }
  require(false, "the device does not become IDLE");
}

void to_force(EmulatedDevice& d, const AxisValues& effort) {
  to_idle(d);
  for (int i = 0; i < kManyFrames; ++i)
    if (d.turn(State::kForce, effort).state == State::kForce) return;
  require(false, "the device does not become FORCE");
}

MotorStage stage(EmulatedDevice& d) { return static_cast<MotorStage>(d.registers().motor_stage); }

float setpoint_Nm(EmulatedDevice& d, unsigned axis) {
  const auto setpoint = static_cast<std::int32_t>(d.registers().motor_setpoint[axis]);
  return static_cast<float>(setpoint) * kFullEffort[axis] / static_cast<float>(kFullSetpoint);
}

void require_shorted(EmulatedDevice& d) {
  require(stage(d) == MotorStage::kShorted, "the motors are not shorted");
  for (unsigned i = 0; i < kAxes; ++i) require(d.registers().motor_setpoint[i] == 0, "a set-point is not zero");
}

void unconnected(EmulatedDevice& d) {
  d.registers().pins = 0;
  StateFrame s;
  for (int i = 0; i < 5; ++i) s = d.next_state();
  require(s.state == State::kBrake, "a device whose board is not connected does not brake");
  require(s.fault == static_cast<std::uint16_t>(Fault::kEmergencyStop), "and its fault is not the e-stop");
  require_shorted(d);
}

void idle_is_off(EmulatedDevice& d) {
  to_idle(d);
  d.await([&](const StateFrame&) { return stage(d) == MotorStage::kOff; }, "the motors are not off in IDLE");
}

void force_reaches_motors(EmulatedDevice& d) {
  to_force(d, kSmall);
  for (int i = 0; i < kManyFrames; ++i) {
    const StateFrame before = d.turn(State::kForce, kSmall);
    const std::array<float, 3> seen{setpoint_Nm(d, 0), setpoint_Nm(d, 1), setpoint_Nm(d, 2)};
    const StateFrame after = d.turn(State::kForce, kSmall);
    // Only between two frames in which nothing fades do the set-points have to be the command's.
    if (before.state != State::kForce || after.state != State::kForce || before.limits != 0 || after.limits != 0)
      continue;
    require(stage(d) == MotorStage::kDriven, "the motors are not driven in FORCE");
    for (unsigned k = 0; k < 3; ++k)
      require(std::abs(seen[k] - kSmall[k]) <= kFullEffort[k] / static_cast<float>(kFullSetpoint),
              "a set-point is not the command's effort");
    return;
  }
  require(false, "the device never stays in FORCE for two frames");
}

void efforts_are_limited(EmulatedDevice& d) {
  to_force(d, kHuge);
  const float limit_Nm = make_configuration().max_force_N;
  bool seen = false;
  for (int i = 0; i < 200; ++i) {
    const StateFrame s = d.turn(State::kForce, kHuge);
    float norm = 0;
    for (unsigned k = 0; k < 3; ++k) norm += setpoint_Nm(d, k) * setpoint_Nm(d, k);
    require(norm <= limit_Nm * limit_Nm * 1.001f, "the set-points are beyond the device's limit");
    const std::uint16_t axes = axis_limit_bit(0) | axis_limit_bit(1) | axis_limit_bit(2);
    seen = seen || (s.state == State::kForce && (s.limits & axes) == axes);
  }
  require(seen, "no frame says that the limits act");
}

void counts_are_told(EmulatedDevice& d) {
  to_idle(d);
  for (std::uint32_t i = 0; i < 50; ++i) {
    d.registers().encoder_count[1] = d.registers().encoder_count[1] - 7;  // 0.9 rad/s if it is one period
    const auto count = static_cast<std::int32_t>(d.registers().encoder_count[1]);
    d.await([&](const StateFrame& s) { return s.counts[1] == count; }, "a count does not come through");
  }
}

void silence_fades_and_brakes(EmulatedDevice& d) {
  to_force(d, kSmall);
  d.await([&](const StateFrame& s) { return d.command_was_taken() || s.state != State::kForce; }, "a command is lost");
  const Config config = make_configuration();
  for (int i = 0; i < 100; ++i) {
    const StateFrame s = d.next_state();
    const unsigned missed = s.missed_commands;
    require((s.state == State::kBrake) == (missed >= config.brake_frames), "the brake comes at another frame");
    const bool fading = (s.limits & bit_of(Limit::kFading)) != 0;
    require(fading == (missed >= config.fade_frames && missed < config.brake_frames), "the fade is at other frames");
    if (s.state != State::kBrake) continue;
    require(s.fault == static_cast<std::uint16_t>(Fault::kCommandsLost), "the fault is not the lost commands");
    return require_shorted(d);
  }
  require(false, "a silent host does not make the device brake");
}

void stop_line_brakes(EmulatedDevice& d) {
  to_force(d, kSmall);
  d.registers().pins = kPinSupplyGood;
  d.forget_waiting();
  // One frame may be of a period that had sampled before, one more may have been on its way.
  constexpr int frames_under_way = 2;
  StateFrame s;
  for (int i = 0; i <= frames_under_way; ++i) s = d.turn(State::kForce, kSmall);
  require(s.state == State::kBrake, "the e-stop does not brake at once");
  require(s.fault == static_cast<std::uint16_t>(Fault::kEmergencyStop), "the fault is not the e-stop");
  require_shorted(d);
  for (int i = 0; i < 50; ++i)
    require(d.turn(State::kForce, kSmall, i % 2 == 0).state == State::kBrake, "re-armed under an active e-stop");
}

// A reply says that the noise before its request was taken: an emulated line takes some ten bytes a period at most.
void noise_moves_nothing(EmulatedDevice& d) {
  to_idle(d);
  std::array<std::byte, 997> noise{};
  std::uint32_t random = 1;
  for (int round = 0; round < 20; ++round) {
    for (std::byte& b : noise) b = static_cast<std::byte>((random = random * 1664525u + 1013904223u) >> 24);
    d.send_bytes(noise);
    const auto stays_off = [&d](int frames) {
      for (int i = 0; i < frames; ++i)
        require(d.next_state().state == State::kIdle && stage(d) == MotorStage::kOff, "noise moves the device");
    };
    stays_off(5);
    d.send_bytes(std::array<std::byte, 1>{});  // ends what the noise began
    require(d.ask(Operation::kRead, number::kAxisCount).value == kAxes, "a request after the noise is not understood");
    stays_off(5);
  }
  to_force(d, kSmall);
}

void registers_answer(EmulatedDevice& d) {
  to_idle(d);
  require(d.ask(Operation::kRead, number::kAxisCount).value == kAxes, "the number of axes is not six");
  require(d.ask(Operation::kRead, number::kSerial).value == serial_word(kIdentity, 0), "the serial number is another");
  require(d.ask(Operation::kRead, 0xffff).status == ServiceStatus::kNoSuchRegister, "a register that is none answers");
}

void await_save(EmulatedDevice& d) {
  for (int i = 0; i < kManyFrames; ++i)
    if (d.ask(Operation::kRead, number::kSaveState).value != static_cast<std::uint32_t>(SaveState::kWriting)) return;
  require(false, "saving the configuration does not end");
}

// After `break_it` the device shorts its motors, falls silent, is reset by its watchdog, and has its saved values.
template <class Break>
void fault_and_restart(EmulatedDevice& d, float max_force_N, bool place_known, Break&& break_it) {
  to_idle(d);
  await_save(d);  // an attempt before this one may have left one under way
  const auto bits = std::bit_cast<std::uint32_t>(max_force_N);
  require(d.ask(Operation::kWrite, number::kMaxForce, bits).status == ServiceStatus::kGood,
          "a register is not written");
  (void)d.next_state();
  (void)d.next_state();  // in force
  require(d.ask(Operation::kExecute, number::kSave).status == ServiceStatus::kGood, "the configuration is not saved");
  await_save(d);
  to_force(d, kSmall);
  d.registers().fault_program_count = 0;
  break_it();
  d.await_fault();
  const bool shorted = stage(d) == MotorStage::kShorted;
  const std::uint32_t place = d.registers().fault_program_count;
  constexpr std::uint32_t flash_end = 64 * 1024;
  d.await_restart();
  require(shorted, "the motors are not shorted when the place of the fault is known");
  // The emulator's watchdog also fires where the PC stands still: then the place is not this fault's.
  if (place_known ? place >= flash_end : place != kUnknownPlace) throw StoodStill();
  require(d.ask(Operation::kRead, number::kMaxForce).value == bits, "what was saved is lost");
  const StateFrame s = d.next_state();
  require(s.state != State::kForce && stage(d) != MotorStage::kDriven, "there is force after a restart");
}

struct Scenario {
  const char* name;
  void (*run)(EmulatedDevice&);
};
constexpr Scenario kScenarios[] = {
    {"a board to which nothing is connected brakes", unconnected},
    {"in IDLE the motors have no current", idle_is_off},
    {"a command's efforts become set-points", force_reaches_motors},
    {"set-points stay within the limits, and the frame says so", efforts_are_limited},
    {"encoder counts come through", counts_are_told},
    {"a silent host: fade from the third frame, brake at the tenth", silence_fades_and_brakes},
    {"the e-stop brakes and cannot be re-armed while it is active", stop_line_brakes},
    {"noise on the line moves nothing, and the line recovers", noise_moves_nothing},
    {"registers answer over the same line", registers_answer},
    {"a bus fault shorts the motors, the watchdog restarts, the configuration is kept",
     [](EmulatedDevice& d) { fault_and_restart(d, 6.5f, true, [&] { d.word(Symbol::kPeriodClock) = 0xa0000000u; }); }},
    {"a stack that is used up shorts the motors, the watchdog restarts",
     [](EmulatedDevice& d) { fault_and_restart(d, 8.0f, false, [&] { d.word(Symbol::kStackLimit) = 0; }); }},
};

bool run(const Scenario& scenario, EmulatedDevice& device) {
  constexpr int max_attempts = 60;
  for (int attempt = 1; attempt <= max_attempts; ++attempt) try {
      scenario.run(device);
      std::printf("  good: %s\n", scenario.name);
      return true;
    } catch (const StoodStill&) { continue; } catch (const Failure& failure) {
      if (device.stands_still_soon()) continue;
      std::printf("  FAILED: %s: %s\n", scenario.name, failure.what());
      return false;
    }
  std::printf("  FAILED: %s: %d attempts, and the PC stood still in each, or so it looks\n", scenario.name,
              max_attempts);
  return false;
}

}  // namespace

int main(int argc, char** argv) {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  if (argc < 3) {
    std::fprintf(stderr, "image_test: usage: image_test IMAGE MEMORY_FILE SYMBOL=ADDRESS...\n");
    return 2;
  }
  try {
    EmulatedDevice device(argv[1], argv[2], std::span<char*>(argv + 3, static_cast<std::size_t>(argc - 3)));
    int good = 0, bad = 0;
    std::size_t deepest = 0;
    for (const Scenario& scenario : kScenarios) {
      if (run(scenario, device))
        ++good;
      else
        ++bad;
      deepest = std::max(deepest, device.stack_high_water());
    }
    std::printf("stack %zu of %zu\n", deepest, device.stack_size());
    std::printf("scenarios %d %d\n", good, bad);
    return bad == 0 ? 0 : 1;
  } catch (const Failure& failure) {
    std::printf("image_test: %s\n", failure.what());
    return 1;
  }
}
