/// \file
/// A device of one's own, in the program's own process: implement Device, and give it to Session::open.
///
/// Frame: the device's own, right-handed, origin in the centre of its workspace, x to the right, y away from the
/// person, z up; the scene's [device] says where that is in the world. Units: SI.
#pragma once

#include "tactus/error.h"
#include "tactus/types.h"

namespace tactus {

/// What the loop must know of a device, as measured at the tool. Everything that the program promises about stability
/// rests on these figures: gains that the device cannot hold are an Error of Session::open.
struct DeviceProperties {
  bool has_rotation{true};                 ///< senses and moves six degrees of freedom; false: three, no torque
  double workspace_radius_m{0.2};          ///< farther from the origin (and 5 %) is a fault, kInputWorkspace
  double max_speed_m_per_s{1.0};           ///< what its mechanics can do at most; faster is a fault, kInputJump
  double max_angular_speed_rad_per_s{10};  ///< same, of its rotation
  double max_force_N{30};                  ///< peak; the loop sends no more
  double max_torque_Nm{3};                 ///< peak; the loop sends no more; 0 without rotation
  double continuous_force_N{10};           ///< that it bears for ever
  double continuous_torque_Nm{1};          ///< that it bears for ever; 0 without rotation
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

/// What became of a Device::read.
enum class Reading : std::uint32_t {
  kFresh = 0,         ///< a new sample
  kMissing = 1,       ///< none came in time: the force fades, after 10 in a row it is a fault
  kCorrupt = 2,       ///< one came and is broken: same
  kDisconnected = 3,  ///< the device is gone: a fault at once
};

/// Where a device is.
struct DeviceSample {
  Vector3 position_m{};             ///< of the tool, device frame
  Quaternion rotation{1, 0, 0, 0};  ///< device from tool; left as it is where there is no rotation
  std::uint32_t buttons{0};         ///< bit 0 first, 1: pressed
  std::uint32_t fault{0};           ///< not 0: the device has a fault, by its own number. Force off until a re-arm
};

/// What a device is told.
struct DeviceCommand {
  Vector3 force_N{};        ///< on the hand, device frame; 0 where force_on is false
  Vector3 torque_Nm{};      ///< on the hand about the tool's origin, device frame; 0 where force_on is false
  bool force_on{false};     ///< the motors may push
  bool brake{false};        ///< a fault is latched: the safest that the device can do, such as shorted motors
  bool clear_fault{false};  ///< a person re-arms: forget a fault, where its cause is gone
};

/// A device that the library does not know. It must outlive the session.
///
/// In virtual time the thread that calls tick() calls read() and write(), once a tick each, in this order: one read()
/// is one period, and a device that is a simulation moves on by it. In real time the haptic thread does, and there both
/// must be quick, a small part of the period together, and must not allocate, lock, wait, log or throw: hand over to a
/// thread of the device's own where its library does any of these. A device must also fade its force and brake by
/// itself where write() is not called for 10 periods: a program that hangs cannot do it.
class Device {
 public:
  Device() = default;
  virtual ~Device() = default;
  Device(const Device&) = delete;             ///< a device is one thing
  Device& operator=(const Device&) = delete;  ///< a device is one thing

  /// [setup] Asked once, in Session::open, before start().
  virtual DeviceProperties properties() const = 0;
  /// [setup] Just before the first tick, and again after Session::reset. An error ends that call, as kMachine.
  /// \param period_s of a tick
  virtual Error start([[maybe_unused]] double period_s) { return {}; }
  /// [rt] The newest sample. `sample` comes with the pose of the last fresh one, no button and no fault. Where the
  /// result is not kFresh, it is not looked at.
  virtual Reading read(DeviceSample& sample) noexcept = 0;
  /// [rt] What the hand shall feel from now on.
  virtual void write(const DeviceCommand& command) noexcept = 0;
  /// [setup] By Session::close, reset, open or the destructor; the last command was without force.
  virtual void stop() noexcept {}
};

}  // namespace tactus
