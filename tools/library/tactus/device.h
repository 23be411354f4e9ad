/// \file
/// Interface for a device that the calling program implements in its own process: derive from Device and pass it to
/// Session::open.
///
/// Frame: the device's own, right-handed, origin in the centre of its workspace, x to the right, y away from the
/// person, z up; the scene's [device] gives its pose in the world. Units: SI.
#pragma once

#include "tactus/error.h"
#include "tactus/types.h"

namespace tactus {

/// Properties of a device, measured at the tool. Every stability guarantee rests on these figures: Session::open
/// returns an Error for gains beyond the device's stability limit.
struct DeviceProperties {
  bool has_rotation{true};         ///< true: six degrees of freedom, measured and actuated; false: three, no torque
  double workspace_radius_m{0.2};  ///< tool farther than this plus 5 % from the origin: fault kInputWorkspace
  double max_speed_m_per_s{1.0};   ///< limit of the mechanism; a faster motion is the fault kInputJump
  double max_angular_speed_rad_per_s{10};  ///< same, rotation
  double max_force_N{30};                  ///< peak; upper limit of the commanded force
  double max_torque_Nm{3};                 ///< peak; upper limit of the commanded torque; 0 without rotation
  double continuous_force_N{10};           ///< continuous rating
  double continuous_torque_Nm{1};          ///< continuous rating; 0 without rotation
  double position_quantum_m{1e-5};         ///< smallest step of a measured position
  double rotation_quantum_rad{1e-4};       ///< smallest step of a measured rotation
  double mass_kg{0.3};                     ///< apparent, at the tool
  double damping_Ns_per_m{0.5};            ///< viscous friction at the tool
  double inertia_kg_m2{1e-3};              ///< apparent, at the tool
  double damping_Nms_per_rad{2e-3};        ///< viscous friction of its rotation
  double delay_s{1e-3};                    ///< from a sample to the force that answers it, beyond sample and hold
  double coulomb_friction_N{0};            ///< dry friction at the tool; 0: none, or not known
  double coulomb_friction_Nm{0};           ///< dry friction of its rotation; 0: none, or not known
};

/// Result of Device::read.
enum class Reading : std::uint32_t {
  kFresh = 0,         ///< a new sample
  kMissing = 1,       ///< no sample in time: the force fades; 10 in a row are a fault
  kCorrupt = 2,       ///< a corrupt sample arrived; treated as kMissing
  kDisconnected = 3,  ///< the device is disconnected: a fault at once
};

/// State of a device at one instant.
struct DeviceSample {
  Vector3 position_m{};             ///< of the tool, device frame
  Quaternion rotation{1, 0, 0, 0};  ///< device from tool; not written by a device without rotation
  std::uint32_t buttons{0};         ///< bit i is 1 while button i is pressed
  std::uint32_t fault{0};           ///< not 0: the device's own fault number. Force off until a re-arm
};

/// Command to a device.
struct DeviceCommand {
  Vector3 force_N{};        ///< on the hand, device frame; 0 where force_on is false
  Vector3 torque_Nm{};      ///< on the hand about the tool's origin, device frame; 0 where force_on is false
  bool force_on{false};     ///< true: the motors may apply force
  bool brake{false};        ///< a fault is latched: apply the safest brake that the device has, such as shorted motors
  bool clear_fault{false};  ///< the operator re-arms: clear a fault whose cause is gone
};

/// Base class of a device that the library does not support. It must outlive the session.
///
/// Virtual time: the thread that calls tick() calls read() and then write(), once per tick each. One read() is one
/// period; a simulated device advances by one period in it. Real time: the haptic thread calls them. There both
/// together must take a small part of the period and must not allocate, lock, wait, log or throw; if the device's
/// library does any of these, exchange data with a thread of the device's own. A device must also fade its force and
/// brake by itself when write() has not been called for 10 periods, because a program that hangs cannot do it.
class Device {
 public:
  Device() = default;
  virtual ~Device() = default;
  Device(const Device&) = delete;             ///< not copyable
  Device& operator=(const Device&) = delete;  ///< not copyable

  /// [setup] Called once, in Session::open, before start().
  virtual DeviceProperties properties() const = 0;
  /// [setup] Just before the first tick, and again after Session::reset. An error ends that call, as kMachine.
  /// \param period_s period of a tick [s]
  virtual Error start([[maybe_unused]] double period_s) { return {}; }
  /// [rt] Returns the newest sample. On entry `sample` holds the pose of the last fresh sample, no button and no fault.
  /// It is ignored unless the result is kFresh.
  virtual Reading read(DeviceSample& sample) noexcept = 0;
  /// [rt] Command to be applied from now on.
  virtual void write(const DeviceCommand& command) noexcept = 0;
  /// [setup] Called by Session::close, reset, open or the destructor. The last command before it had no force.
  virtual void stop() noexcept {}
};

}  // namespace tactus
