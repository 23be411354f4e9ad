// A 3D Systems device (Touch, Touch X, Phantom) through the library HD: SdkPort with the library's scheduler.
//
// All that concerns the device's state happens in one frame per call of the scheduler: pose and buttons out, the newest
// force in. The library's own soft start of forces stays as its user has set it; its cut to the device's largest force
// is switched on. A device that requests calibration and can calibrate itself (the stylus was put into its inkwell) is
// calibrated while it applies no force; a request while it applies force is a fault.
// Thread: open() [setup]; the rest as sdk_port.h says. Frame: the library's x points to the right, y up, z to the
// person; the device's x to the right, y away from the person, z up, the origin at the centre of the workspace that the
// library calls usable. Units: SI; the library's are mm, N and mN m. Not tried on a device.
#pragma once

#include <memory>
#include <string>

#include "hal/sdk/hd_library.h"
#include "hal/sdk/sdk_port.h"

namespace tactus::hal {

class HdPort final : public SdkPort {
 public:
  // A pose that requires a higher speed since the last one is rejected: users report such jumps.
  static constexpr double kJump_m_per_s = 5;

  // `name`: of a device as the maker's setup program calls it; empty: the default one. Error, one line: none there, in
  // use, no licence, another version of the library, figures that make no sense.
  static Result<std::unique_ptr<HdPort>> open(std::unique_ptr<HdLibrary> library, const std::string& name);
  ~HdPort() override;
  HdPort(const HdPort&) = delete;
  HdPort& operator=(const HdPort&) = delete;

  // "3D Systems Touch, serial 1234, HD 3.4.0".
  const std::string& identity() const noexcept { return identity_; }
  const haptics::DeviceProperties& properties() const noexcept override { return properties_; }
  SdkResult exchange(const Wrenchd& wrench, SdkState& state) noexcept override;
  bool enable_forces(bool on) noexcept override;
  std::string watchdog() const override;
  bool has_scheduler() const noexcept override { return true; }
  // Error, one line: the scheduler does not start, or runs at another rate.
  Status start_calls(const SdkCall& call, std::int64_t period_ns) override;
  void stop_calls() noexcept override;

 private:
  explicit HdPort(std::unique_ptr<HdLibrary> library) : library_(std::move(library)), f_(library_->functions()) {}
  Status prepare(const std::string& name);
  Status read_identity();
  Status read_figures();
  Status refused(const char* what, std::uint32_t code) const;
  std::uint32_t take_error() const noexcept;
  void look_at_calibration(SdkState& state) noexcept;
  bool read_pose(SdkState& state) noexcept;
  void send(const Wrenchd& wrench) const noexcept;
  double time_s() const noexcept;

  std::unique_ptr<HdLibrary> library_;
  const HdFunctions& f_;
  std::uint32_t handle_{0xffffffff};  // no device
  bool open_{false}, forces_{false}, running_{false}, placed_{false};
  Vec3d centre_, last_;  // m, the library's frame; last_: of the frame before
  double period_s_{1e-3};
  unsigned long scheduled_{0};
  SdkCall call_;
  std::string identity_;
  haptics::DeviceProperties properties_;
};

}  // namespace tactus::hal
