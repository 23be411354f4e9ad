// Fault and status codes. Numbers are explicit and never reused: they go to tapes, logs and reports.
//
// A fault latches: the force goes to zero and stays zero until an explicit re-arm. A status is a condition of one tick
// and recovers without a re-arm. Thread: [any].
#pragma once

#include <cstdint>
#include <string_view>

namespace tactus {

enum class Fault : std::uint32_t {
  kNone = 0,
  kLinkLost = 1,          // 10 frames in a row missing
  kDeviceUnplugged = 2,   // the link reports that the device is gone
  kInputNotFinite = 3,    // NaN or infinity in 3 samples in a row
  kInputRotation = 4,     // quaternion norm off 1 by more than 1e-3, 3 in a row
  kInputWorkspace = 5,    // outside the device's workspace + 5 %, 3 in a row
  kInputJump = 6,         // moved faster than the device can, 3 in a row
  kInputStale = 7,        // sequence or device time does not advance, 10 in a row
  kDeviceBrake = 8,       // the device reports BRAKE
  kDeviceFault = 9,       // the device reports a fault of its own
  kOutputNotFinite = 10,  // our own wrench was not finite
  kEmergencyStop = 11,    // the e-stop line is active
  kWorldLost = 12,        // reserved
  kDeviceLeftForce = 13,  // the device was in FORCE, is commanded to stay there, and is in IDLE or RESET
  kForceRefused = 14,     // the device accepts commands that request FORCE, and stays in IDLE or RESET
};

enum StatusBit : std::uint32_t {
  kFrameMissing = 1u << 0,    // no valid frame in this tick
  kForceFading = 1u << 1,     // 3 or more in a row missing or rejected
  kInputRejected = 1u << 2,   // a frame arrived and the input guard rejected it
  kForceSaturated = 1u << 3,  // force or torque saturated at the limit
  kSlewLimited = 1u << 4,
  kPassivityActive = 1u << 5,    // the passivity controller adds damping
  kWorldLate = 1u << 6,          // the cycle is longer than r ticks
  kBorderFrozen = 1u << 7,       // late by more than 4 r ticks: outside bodies count as at rest
  kWorldFade = 1u << 8,          // late by more than 100 ms: the force is faded out
  kSolverCut = 1u << 9,          // the cut predicate fired
  kSubStepsReduced = 1u << 10,   // the governor chose fewer sub-steps than configured
  kCapacityExceeded = 1u << 11,  // see the capacity bits
  kNotArmed = 1u << 12,          // no force until armed
  kProxyContact = 1u << 13,      // the proxy is in contact; not a limit, but recorded in every tick
  kBorderSpent = 1u << 14,       // the border's energy tank is empty: it only takes energy
  kSceneReset = 1u << 15,        // a scene reset is in progress: the force fades and stays off until it is done
};

// One line for users: what happened and what to do. Never empty.
std::string_view describe(Fault fault) noexcept;
// Short word for a status line. Empty for an unknown bit.
std::string_view name_of(StatusBit bit) noexcept;

}  // namespace tactus
