// Faults and limits that the device reports, by number. Numbers are explicit, never reused, and used on the wire.
//
// Two separate ranges: 1 to 63 are faults (the device went to BRAKE and stays there until it is re-armed), 64 to 79 are
// limits (the device limits or refuses something in this period; this ends by itself). Thread: [any].
#pragma once

#include <cstdint>

namespace tactus::firmware {

enum class Fault : std::uint16_t {
  kNone = 0,
  kCommandsLost = 1,      // brake_frames consecutive periods without an acceptable command, in FORCE
  kEmergencyStop = 2,     // the e-stop line is or was active
  kOverspeed = 3,         // an axis moved faster than its limit: a run-away, or an encoder that jumps
  kEffortNotFinite = 4,   // a command with NaN or infinity arrived: an error in the host's program
  kMotorBus = 5,          // the motors' supply failed
  kBadConfiguration = 6,  // the device's configuration is invalid; a re-arm does not clear it
  kEncoder = 7,           // line fault, impossible transition, or index pulses at impossible distances
  kOverheated = 8,        // a winding is at its hard limit, modelled or measured; clears after cooling down
  kSelfTest = 9,          // tables, configuration or watchdog differ from what was built
};

enum class Limit : std::uint16_t {
  kAxis0 = 64,  // effort of this axis reduced to its motor's limit; kAxis1 to kAxis5 follow
  kAxis1 = 65,
  kAxis2 = 66,
  kAxis3 = 67,
  kAxis4 = 68,
  kAxis5 = 69,
  kForce = 70,          // norm of the efforts of axes 0 to 2 reduced to its limit
  kTorque = 71,         // norm of the efforts of axes 3 to 5 reduced to its limit
  kFading = 72,         // commands are missing: the effort fades
  kEmergencyStop = 73,  // the e-stop line is active now
  kMotorBusLow = 74,    // the motors' supply is not good now
  kWarm = 75,           // a winding is above its warning level: its effort limit falls with further rise
  kNotHomed = 76,       // homing is required and not done: FORCE is refused
  kHoming = 77,         // homing is in progress: FORCE is refused
  kIdleFirst = 78,      // no command has requested IDLE since the device started: FORCE is refused
};

inline constexpr std::uint16_t kFirstLimit = 64, kLastLimit = 79;

// The limit's bit in the state frame.
constexpr std::uint16_t bit_of(Limit limit) noexcept {
  return static_cast<std::uint16_t>(1u << (static_cast<std::uint16_t>(limit) - kFirstLimit));
}
constexpr std::uint16_t axis_limit_bit(unsigned axis) noexcept { return static_cast<std::uint16_t>(1u << axis); }

static_assert(bit_of(Limit::kAxis5) == axis_limit_bit(5));

}  // namespace tactus::firmware
