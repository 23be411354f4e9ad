// The values exchanged with a device once a tick: sample and command. HAL implementations convert their frames to
// these, in SI, once.
//
// Frame: the device's own (right-handed, origin at its workspace centre); the loop maps it into the scene.
// Thread: [rt] values. All trivially copyable; the tape holds them as they are.
#pragma once

#include <concepts>
#include <cstdint>

#include "rt/base/spatial.h"

namespace tactus::haptics {

// The device's own state machine (firmware). Numbers are those on the wire.
enum class DeviceState : std::uint32_t { kReset = 0, kIdle = 1, kForce = 2, kBrake = 3 };

enum class ReadStatus : std::uint32_t {
  kFresh = 0,         // a new, intact frame
  kMissing = 1,       // no frame arrived in time
  kCorrupt = 2,       // a frame arrived and failed its check
  kDisconnected = 3,  // the link reports that the device is gone
};

struct DeviceSample {
  std::uint64_t sequence{0};        // of the frame; counted by the device
  std::uint64_t device_time_ns{0};  // device clock at the sample
  Posed device_from_tool;           // m, unit quaternion
  DeviceState state{DeviceState::kReset};
  std::uint32_t device_fault{0};     // the firmware's fault number, 0 none
  std::uint32_t limits{0};           // the firmware's limit-active bits
  std::uint32_t buttons{0};          // bit 0 first
  std::uint64_t echoed_sequence{0};  // sequence of the newest command received before the sample
  std::uint32_t missed_commands{0};  // consecutive periods without a command, counted by the device
  std::uint32_t padding{0};
};

struct DeviceInput {
  ReadStatus status{ReadStatus::kMissing};
  std::uint32_t padding{0};
  DeviceSample sample;  // the last one received, if status is not kFresh
};

struct DeviceCommand {
  std::uint64_t sequence{0};               // counted by the loop, one per tick
  Wrenchd wrench;                          // N, N m, device frame, about the tool's origin: on the hand
  DeviceState wanted{DeviceState::kIdle};  // kIdle, kForce or kBrake
  std::uint32_t rearm{0};  // 1: leave a latched BRAKE. The device acts on the change from 0 to 1: to ask again,
                           // send 0 first. Not together with wanting kBrake
};

// Properties of a device that the loop uses. From its description; fixed after start.
struct DeviceProperties {
  bool has_rotation{true};  // 6-DoF sensing and actuation; false: 3 DoF, the tool keeps its orientation
  double workspace_radius_m{0.2};
  double max_speed_m_per_s{1.0};  // mechanical limit: the paper's v_max
  double max_angular_speed_rad_per_s{10.0};
  double max_force_N{30.0}, max_torque_Nm{3.0};  // peak: the saturation limits of the loop
  double continuous_force_N{10.0}, continuous_torque_Nm{1.0};
  double position_quantum_m{1e-5}, rotation_quantum_rad{1e-4};
  double mass_kg{0.3}, damping_Ns_per_m{0.5}, inertia_kg_m2{1e-3}, damping_Nms_per_rad{2e-3};  // apparent, at the tool
  double delay_s{1e-3};                                  // transport delay beyond the sample-and-hold
  double coulomb_friction_N{0}, coulomb_friction_Nm{0};  // dry friction at the tool; 0: none or unknown
};

// A device on a link. read() and write() are [rt]: bounded time, no allocation, no lock, no throw.
template <class D>
concept HapticDevice = requires(D device, DeviceInput& input, const DeviceCommand& command) {
  { device.properties() } -> std::convertible_to<const DeviceProperties&>;
  { device.read(input) }
  noexcept->std::same_as<void>;  // the newest sample; never waits beyond the link's bound
  { device.write(command) }
  noexcept->std::same_as<void>;  // passes the command to the link
};

static_assert(std::is_trivially_copyable_v<DeviceInput> && std::is_trivially_copyable_v<DeviceCommand>);

}  // namespace tactus::haptics
