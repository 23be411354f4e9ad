// What the device can report about itself, by number. Numbers are explicit, never reused, and are those on the wire.
//
// Two ranges that never meet: 1 to 63 are faults (the device went to BRAKE and stays there until it is re-armed), 64 to
// 79 are limits (something is being held back in this period; it recovers by itself). Thread: [any].
#pragma once

#include <cstdint>

namespace tactus::firmware {

enum class Fault : std::uint16_t {
  kNone = 0,
  kCommandsLost = 1,      // brake_frames periods in a row without an acceptable command, in FORCE
  kEmergencyStop = 2,     // the e-stop line is or was active
  kOverspeed = 3,         // an axis moved faster than its limit: a run-away, or an encoder that jumps
  kEffortNotFinite = 4,   // a command with NaN or infinity came: the host's program is wrong
  kMotorBus = 5,          // the motors' supply failed
  kBadConfiguration = 6,  // the device's own configuration makes no sense; not cured by a re-arm
  kEncoder = 7,           // line fault, impossible transition, or index pulses at distances that cannot be
  kOverheated = 8,        // a winding is at its hard limit, modelled or measured; cured by cooling down
  kSelfTest = 9,          // tables, configuration or watchdog are not what they were built to be
};

enum class Limit : std::uint16_t {
  kAxis0 = 64,  // effort of this axis cut to its motor's limit; kAxis1 to kAxis5 follow
  kAxis1 = 65,
  kAxis2 = 66,
  kAxis3 = 67,
  kAxis4 = 68,
  kAxis5 = 69,
  kForce = 70,        // norm of the efforts of axes 0 to 2 cut
  kTorque = 71,       // norm of the efforts of axes 3 to 5 cut
  kFading = 72,       // commands are missing: the effort fades
  kStopLine = 73,     // the e-stop line is active now
  kMotorBusLow = 74,  // the motors' supply is not good now
  kWarm = 75,         // a winding is above its warning: its effort is cut further the hotter it gets
  kNotHomed = 76,     // homing is demanded and not done: FORCE is refused
  kHoming = 77,       // homing is under way: FORCE is refused
  kIdleFirst = 78,    // no command has wanted IDLE since the device started: FORCE is refused
};

inline constexpr std::uint16_t kFirstLimit = 64, kLastLimit = 79;

// The limit's bit in the state frame.
constexpr std::uint16_t bit_of(Limit limit) noexcept {
  return static_cast<std::uint16_t>(1u << (static_cast<std::uint16_t>(limit) - kFirstLimit));
}
constexpr std::uint16_t axis_limit_bit(unsigned axis) noexcept { return static_cast<std::uint16_t>(1u << axis); }

static_assert(bit_of(Limit::kAxis5) == axis_limit_bit(5));

}  // namespace tactus::firmware
