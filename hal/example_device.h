// A template for a new device: a class that calls the maker's library directly, without frames or links.
//
// Copy it, replace PuckLibrary's calls by the maker's, and add the class to the list in
// tests/hal/device_contract_test.cpp, which tests what hal/classes/README.md requires of a device. Here the library is
// a simulated puck, held to its centre by springs, with its own units and axes, as is common for such libraries.
// Thread: construction [setup]; read(), write() [rt] by the haptic thread: no wait, no allocation, no lock, no throw.
// Frame: the device's: x to the right, y away from the person, z up. Units: SI. One read() is one period.
#pragma once

#include <algorithm>

#include "rt/haptics/device.h"

namespace tactus::hal {

// Stands for a maker's library: millimetres, y down, z towards the person.
class PuckLibrary {
 public:
  struct Millimetres {
    double x{0}, y{0}, z{0};
  };
  Millimetres position() const noexcept { return position_mm_; }
  void set_force(double x_N, double y_N, double z_N) noexcept { force_N_ = {x_N, y_N, z_N}; }
  void force(double& x_N, double& y_N, double& z_N) const noexcept {
    x_N = force_N_.x;
    y_N = force_N_.y;
    z_N = force_N_.z;
  }

  // Simulation only: a real device needs no such call.
  void simulate(double time_s) noexcept {
    constexpr double kMass_kg = 0.1, kStiffness_N_per_m = 40.0, kDamping_Ns_per_m = 1.0;
    const Vec3d spring = Vec3d{position_mm_.x, position_mm_.y, position_mm_.z} * (-1e-3 * kStiffness_N_per_m);
    velocity_m_per_s_ += (force_N_ + spring - velocity_m_per_s_ * kDamping_Ns_per_m) * (time_s / kMass_kg);
    const Vec3d way_mm = velocity_m_per_s_ * (1e3 * time_s);
    position_mm_ = {position_mm_.x + way_mm.x, position_mm_.y + way_mm.y, position_mm_.z + way_mm.z};
  }

 private:
  Millimetres position_mm_;
  Vec3d velocity_m_per_s_, force_N_;
};

class ExampleDevice {
 public:
  // [setup] Measured figures of the device; every guarantee of the program depends on them.
  ExampleDevice() noexcept {
    properties_.has_rotation = false;
    properties_.workspace_radius_m = 0.1;
    properties_.max_speed_m_per_s = 1.0;
    properties_.max_force_N = 4.0;
    properties_.continuous_force_N = 2.0;
    properties_.max_torque_Nm = properties_.continuous_torque_Nm = 0.0;
    properties_.position_quantum_m = 1e-5;
    properties_.mass_kg = 0.1;
    properties_.damping_Ns_per_m = 1.0;
    properties_.delay_s = kPeriod_s;
  }

  const haptics::DeviceProperties& properties() const noexcept { return properties_; }

  void read(haptics::DeviceInput& input) noexcept {
    watch_over_commands();
    push();
    library_.simulate(kPeriod_s);
    const PuckLibrary::Millimetres at = library_.position();
    ++sample_.sequence;  // if the device numbers its samples, use its number, so that repeated samples are detected
    sample_.device_time_ns += static_cast<std::uint64_t>(kPeriod_s * 1e9);  // the device's clock, if it has one
    sample_.device_from_tool.position = {1e-3 * at.x, -1e-3 * at.z, -1e-3 * at.y};
    sample_.state = state_;
    sample_.device_fault = fault_;
    sample_.echoed_sequence = command_.sequence;
    input = {haptics::ReadStatus::kFresh, 0, sample_};  // kMissing, kCorrupt, kDisconnected where the library says so
  }

  void write(const haptics::DeviceCommand& command) noexcept {
    using haptics::DeviceState;
    const bool rearms = command.rearm != 0 && command_.rearm == 0;  // rising edge only, so a stuck flag has no effect
    command_ = command;
    missed_ = 0;
    if (!is_finite(command.wrench)) return brake(kForceNotFinite);
    if (command.wanted == DeviceState::kBrake) return brake(kNoFault);
    if (state_ != DeviceState::kBrake)
      state_ = command.wanted == DeviceState::kForce ? DeviceState::kForce : DeviceState::kIdle;
    else if (rearms) {
      state_ = DeviceState::kIdle;
      fault_ = kNoFault;
    }
  }

  // N, device frame: the force on the mechanism, for the test.
  Vec3d force() const noexcept {
    Vec3d f;
    library_.force(f.x, f.y, f.z);
    return {f.x, -f.z, -f.y};
  }

 private:
  static constexpr double kPeriod_s = 1e-3;
  static constexpr std::uint32_t kNoFault = 0, kCommandsLost = 1, kForceNotFinite = 4;  // as firmware/faults.h
  static constexpr std::uint32_t kFadeMissed = 3, kBrakeMissed = 10;

  // Missing commands must fade the force, whatever the host's program does. A watchdog in the real device or its
  // library is better: this one runs in the program that it monitors.
  void watch_over_commands() noexcept {
    if (missed_ <= kBrakeMissed) ++missed_;  // 1: the command that the last write brought
    if (missed_ > kBrakeMissed && state_ == haptics::DeviceState::kForce) brake(kCommandsLost);
  }

  void push() noexcept {
    Vec3d force;
    if (state_ == haptics::DeviceState::kForce) {
      const double size = norm(command_.wrench.force), most = properties_.max_force_N;
      force = command_.wrench.force * (size > most ? most / size : 1.0);
      const std::uint32_t missed = missed_ - 1;
      if (missed >= kFadeMissed) force = force * (static_cast<double>(kBrakeMissed - missed) / (kBrakeMissed - 2));
    }
    library_.set_force(force.x, -force.z, -force.y);
  }

  void brake(std::uint32_t fault) noexcept {
    if (state_ != haptics::DeviceState::kBrake) fault_ = fault;  // keep the first cause
    state_ = haptics::DeviceState::kBrake;
  }

  PuckLibrary library_;
  haptics::DeviceProperties properties_;
  haptics::DeviceSample sample_;
  haptics::DeviceCommand command_;  // the newest
  haptics::DeviceState state_{haptics::DeviceState::kIdle};
  std::uint32_t fault_{kNoFault}, missed_{kBrakeMissed};
};

static_assert(haptics::HapticDevice<ExampleDevice>);

}  // namespace tactus::hal
