// A Force Dimension device (omega, delta, sigma, lambda) through its library: SdkPort.
//
// Thread: open() [setup], then one owner. Frame: the library's x points to the person, y to the right, z up; the
// device's x to the right, y away from the person, z up. Units: SI. Not tried on a device.
#pragma once

#include <memory>
#include <string>

#include "hal/sdk/dhd_library.h"
#include "hal/sdk/sdk_port.h"
#include "rt/base/result.h"

namespace tactus::hal {

class DhdPort final : public SdkPort {
 public:
  // The first device. Error, one line: none there, in use, not initialised, of an unknown type.
  static Result<std::unique_ptr<DhdPort>> open(std::unique_ptr<DhdLibrary> library);
  ~DhdPort() override;
  DhdPort(const DhdPort&) = delete;
  DhdPort& operator=(const DhdPort&) = delete;

  // "Force Dimension omega.6, serial 1234, SDK 3.17.5".
  const std::string& identity() const noexcept { return identity_; }
  const haptics::DeviceProperties& properties() const noexcept override { return properties_; }
  SdkResult exchange(const Wrenchd& wrench, SdkState& state) noexcept override;
  bool enable_forces(bool on) noexcept override;

 private:
  explicit DhdPort(std::unique_ptr<DhdLibrary> library) : library_(std::move(library)), f_(library_->functions()) {}
  Status prepare();

  std::unique_ptr<DhdLibrary> library_;
  const DhdFunctions& f_;
  int id_{-1};
  bool forces_{false};
  std::string identity_;
  haptics::DeviceProperties properties_;
};

}  // namespace tactus::hal
