// The state machine of a device without tactus' firmware, kept by the host: the newest command, the present state, the
// first fault until a re-arm, and the number of missing commands.
//
// Only the rising edge of a re-arm leaves BRAKE. Missing commands fade the force from the third period on and brake in
// the tenth, as the firmware does for a device that has it (firmware/PROTOCOL.md). The owner decides what each state
// does to the motors. Thread: [rt], one; constant time, no allocation, no lock.
#pragma once

#include <cstdint>

#include "firmware/faults.h"
#include "rt/haptics/device.h"

namespace tactus::hal {

inline constexpr std::uint32_t kFadeMissed = 3, kBrakeMissed = 10;  // periods without a command, in a row

constexpr std::uint32_t number_of(firmware::Fault fault) noexcept { return static_cast<std::uint32_t>(fault); }

// The share of the force that remains after so many periods without a command: 1 to 0.
constexpr double share_after(std::uint32_t missed) noexcept {
  if (missed < kFadeMissed) return 1.0;
  return missed < kBrakeMissed ? static_cast<double>(kBrakeMissed - missed) / (kBrakeMissed - kFadeMissed + 1) : 0.0;
}

class HostStates {
 public:
  enum class Next : std::uint8_t {
    kStay = 0,     // it is in BRAKE
    kRearmed = 1,  // it left BRAKE by this command and is in IDLE, without fault
    kFollow = 2,   // what is wanted, IDLE or FORCE, may be done
  };

  explicit HostStates(haptics::DeviceState first = haptics::DeviceState::kIdle) noexcept : state_(first) {}

  haptics::DeviceState state() const noexcept { return state_; }
  std::uint32_t fault() const noexcept { return fault_; }  // the first cause of BRAKE; 0: none
  // The newest one; what is not finite in it is zero.
  const haptics::DeviceCommand& command() const noexcept { return command_; }
  // Periods without a command; 0 in the period after one.
  std::uint32_t missed() const noexcept { return waited_ > 0 ? waited_ - 1 : 0; }
  bool commands_lost() const noexcept { return waited_ > kBrakeMissed; }

  // Once in each read().
  void begin_period() noexcept { waited_ += waited_ <= kBrakeMissed; }

  // Once in each write(). Brakes by fault 4 if the wrench is not finite, without fault if BRAKE is wanted. With
  // `may_rearm` false a re-arm is ignored.
  Next accept(const haptics::DeviceCommand& command, bool may_rearm = true) noexcept {
    const bool rearms = command.rearm != 0 && command_.rearm == 0;  // the edge, so that a stuck flag has no effect
    command_ = command;
    waited_ = 0;
    if (!is_finite(command.wrench)) {
      command_.wrench = {};
      brake(number_of(firmware::Fault::kEffortNotFinite));
    } else if (command.wanted == haptics::DeviceState::kBrake) {
      brake(0);
    } else if (state_ != haptics::DeviceState::kBrake) {
      return Next::kFollow;
    } else if (rearms && may_rearm) {
      state_ = haptics::DeviceState::kIdle;
      fault_ = 0;
      return Next::kRearmed;
    }
    return Next::kStay;
  }

  // A state that the owner has reached. Precondition: it is not BRAKE.
  void enter(haptics::DeviceState state) noexcept { state_ = state; }

  void brake(std::uint32_t fault) noexcept {
    if (state_ != haptics::DeviceState::kBrake) fault_ = fault;  // the first cause
    state_ = haptics::DeviceState::kBrake;
  }

 private:
  haptics::DeviceCommand command_;
  haptics::DeviceState state_;
  std::uint32_t fault_{0}, waited_{0};
};

}  // namespace tactus::hal
