// The Falcon as tactus sees a device: states, forces to motor values, counts to poses. No I/O.
//
// IDLE and BRAKE: motor values of zero; the device cannot short its motors. FORCE only while all axes are homed; a
// homed bit that clears is a fault (falcon_faults.h). No watchdog in the device is known, so the thread that owns the
// port sends zeros whenever the exchange ends (falcon_device.h). If the process is killed, the motors keep the last
// values: use the e-stop on the supply. Thread: construction [setup], the rest [rt], one thread; no allocation, no
// lock, bounded. Units: SI.
#pragma once

#include "hal/falcon/delta_arm.h"
#include "hal/falcon/falcon_packet.h"
#include "hal/host_states.h"

namespace tactus::hal {

// Motor values per N m of an axis. Found by trying, by others; the maker's driver fits 2300 to 4600: an estimate.
inline constexpr double kFalconGain = 10000;
inline constexpr double kFalconForce_N = 8;  // largest at the tool

class FalconLogic {
 public:
  FalconLogic(double gain_per_Nm, std::int64_t period_ns);

  const haptics::DeviceProperties& properties() const noexcept { return properties_; }
  // One period: the newest state of the device, null if none came.
  void read(const FalconState* fresh, bool connected, std::uint64_t echoed, haptics::DeviceInput& input) noexcept;
  void write(const haptics::DeviceCommand& command) noexcept;
  // For the device now: without force unless in FORCE; missing commands fade it.
  FalconRequest request() const noexcept;
  std::uint64_t commanded() const noexcept { return states_.command().sequence; }

 private:
  double gain_per_Nm_;
  std::int64_t period_ns_;
  haptics::DeviceProperties properties_;
  haptics::DeviceSample sample_;
  HostStates states_;
  AxisVector q_{};
  Vec3d place_{0, 0, 0.125};  // maker's frame: where the next search begins
  bool homed_{false};
  std::uint64_t periods_{0};
};

}  // namespace tactus::hal
