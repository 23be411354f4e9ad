// A Force Dimension device (omega, delta, sigma, lambda) through its library: SdkPort.
//
// Thread: open() [setup], then one owner. Frame: the library's x points to the person, y to the right, z up; the
// device's x to the right, y away from the person, z up. Units: SI. Not tried on a device.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "hal/sdk/dhd_library.h"
#include "hal/sdk/sdk_port.h"
#include "rt/base/result.h"

namespace tactus::hal {

class DhdPort final : public SdkPort {
 public:
  // The device with this serial number; without one, the first. Error, one line: none there, in use, not initialised,
  // of an unknown type.
  static Result<std::unique_ptr<DhdPort>> open(std::unique_ptr<DhdLibrary> library,
                                               std::optional<unsigned> serial = std::nullopt);
  ~DhdPort() override;
  DhdPort(const DhdPort&) = delete;
  DhdPort& operator=(const DhdPort&) = delete;

  // "Force Dimension omega.6, serial 1234, SDK 3.17.5", and after it what could not be set: its watchdog, for one.
  const std::string& identity() const noexcept { return identity_; }
  const haptics::DeviceProperties& properties() const noexcept override { return properties_; }
  SdkResult exchange(const Wrenchd& wrench, SdkState& state) noexcept override;
  bool enable_forces(bool on) noexcept override;
  std::string watchdog() const override;

 private:
  explicit DhdPort(std::unique_ptr<DhdLibrary> library) : library_(std::move(library)), f_(library_->functions()) {}
  Status prepare(std::optional<unsigned> serial);
  Status open_device(std::optional<unsigned> serial);
  // Watchdog and time guard. What could not be set, as words for the identity.
  std::string set_expert();
  std::string last_error() const;

  std::unique_ptr<DhdLibrary> library_;
  const DhdFunctions& f_;
  int id_{-1};
  bool forces_{false}, has_watchdog_{false};
  std::string identity_;
  haptics::DeviceProperties properties_;
};

}  // namespace tactus::hal
