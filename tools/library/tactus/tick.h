/// \file
/// Result of one tick: force, motion of the proxy, counts, energy, faults.
///
/// A plain value with the same layout in every build of this version. Thread: any. Units: SI, in the names. Frame: in
/// the descriptions.
#pragma once

#include <string_view>
#include <type_traits>

#include "tactus/types.h"

namespace tactus {

/// A fault latches: the force goes to zero and stays there until a re-arm, Request::kRearm or Options::rearm.
enum class FaultCode : std::uint32_t {
  kNone = 0,              ///< no fault is latched
  kLinkLost = 1,          ///< 10 samples in a row missing or corrupt
  kDeviceUnplugged = 2,   ///< Reading::kDisconnected, or the link reports it
  kInputNotFinite = 3,    ///< NaN or infinity in 3 samples in a row
  kInputRotation = 4,     ///< the quaternion's norm differs from 1 by more than 1e-3, 3 in a row
  kInputWorkspace = 5,    ///< outside the device's workspace plus 5 %, 3 in a row
  kInputJump = 6,         ///< moved faster than the device can, 3 in a row
  kInputStale = 7,        ///< sequence or device time does not advance, 10 in a row
  kDeviceBrake = 8,       ///< the device reports that it brakes
  kDeviceFault = 9,       ///< the device reports a fault of its own
  kOutputNotFinite = 10,  ///< the wrench computed by the loop was not finite
  kEmergencyStop = 11,    ///< the emergency-stop line is active
  kWorldLost = 12,        ///< reserved
  kDeviceLeftForce = 13,  ///< the device left the FORCE state by itself
  kForceRefused = 14,     ///< the device accepts commands but produces no force
};

/// Description of a fault and its remedy; never empty.
std::string_view describe(FaultCode fault) noexcept;

/// A condition of one tick, which clears by itself. Each is a bit of Tick::conditions.
enum class Condition : std::uint32_t {
  kFrameMissing = 1u << 0,       ///< no valid sample in this tick
  kForceFading = 1u << 1,        ///< 3 or more in a row missing or rejected
  kInputRejected = 1u << 2,      ///< a sample was rejected
  kForceSaturated = 1u << 3,     ///< force or torque cut to the device's limit
  kSlewLimited = 1u << 4,        ///< rate of change of the force limited
  kPassivityActive = 1u << 5,    ///< passivity controller active: it adds damping
  kWorldLate = 1u << 6,          ///< the global world's step takes longer than the cycle
  kBorderFrozen = 1u << 7,       ///< global world late by more than 4 cycles: border at rest
  kWorldFade = 1u << 8,          ///< global world late by more than 100 ms: the force is faded out
  kSolverCut = 1u << 9,          ///< the solver was stopped early for lack of time
  kSubStepsReduced = 1u << 10,   ///< fewer sub-steps than the scene asks for
  kCapacityExceeded = 1u << 11,  ///< a capacity was exceeded; entries were left out
  kNotArmed = 1u << 12,          ///< no force until armed
  kProxyContact = 1u << 13,      ///< the proxy touches something
  kBorderSpent = 1u << 14,       ///< the border's energy tank is empty
  kSceneReset = 1u << 15,        ///< the scene is being reset, with the force off
};

/// Short description of a condition; empty for an invalid value.
std::string_view describe(Condition condition) noexcept;

/// What came of one tick.
struct Tick {
  std::uint64_t number{0};                     ///< from 0
  double time_s{0};                            ///< at its end, on the haptic clock: (number + 1) periods
  Vector3 force_N{};                           ///< commanded, on the hand, device frame
  Vector3 torque_Nm{};                         ///< same, about the tool's origin, device frame
  Vector3 proxy_position_m{};                  ///< centre of mass of the proxy, world
  Quaternion proxy_rotation{};                 ///< world from its principal axes (BodyInfo)
  Vector3 proxy_velocity_m_per_s{};            ///< world
  Vector3 proxy_angular_velocity_rad_per_s{};  ///< world
  Vector3 target_position_m{};                 ///< pose that the device commands for the centre of mass, world
  Quaternion target_rotation{};                ///< same, world from target
  Vector3 tool_position_m{};                   ///< last measured, device frame
  Quaternion tool_rotation{};                  ///< same, device from tool
  double device_energy_J{0};          ///< from the hand into the device so far; negative: net energy to the hand
  double damped_energy_J{0};          ///< dissipated by the passivity controller so far
  double border_work_J{0};            ///< done by the border on the members so far
  double border_tank_J{0};            ///< energy stored for the border
  double deepest_overlap_m{0};        ///< deepest contact of the members, in this tick
  FaultCode fault{FaultCode::kNone};  ///< latched
  std::uint32_t conditions{0};        ///< bits of Condition
  std::uint32_t device_fault{0};      ///< the device's own fault number; 0: none
  std::uint32_t buttons{0};           ///< of the device, bit 0 first, 1: pressed
  std::uint32_t members{0};           ///< bodies in the sub-world, the proxy included
  std::uint32_t border{0};            ///< contact points between members and outside bodies
  std::uint32_t contacts{0};          ///< pairs of bodies in contact in the sub-world
  std::uint32_t sub_steps{0};         ///< sub-steps of this tick
  std::uint32_t synchronised{0};      ///< 1: a new snapshot of the global world was imported at its beginning
  std::uint32_t reserved{0};          ///< 0

  /// True: `condition` is set in this tick.
  bool has(Condition condition) const noexcept { return (conditions & static_cast<std::uint32_t>(condition)) != 0; }
};
static_assert(std::is_trivially_copyable_v<Tick> && sizeof(Tick) == 360, "a layout that files and NumPy may rely on");

}  // namespace tactus
