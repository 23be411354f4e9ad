// The suite for devices that do not speak firmware/PROTOCOL.md (an arm of drives, a maker's own class): what every
// device must do, asked through HapticDevice alone (hal/classes/README.md, "What a device must do").
//
// Zero force throughout, unless the operator allows pushes. As in a run, the force ends and BRAKE is wanted when
// samples do not come for ten periods, or the device reports a fault. The device is left in IDLE; one that does not
// answer, or keeps its fault, in BRAKE. Thread: normal; in real time the exchange runs on a thread of its own, set up
// as asked.
#pragma once

#include "hal/device_class.h"
#include "tools/hil/suite.h"

namespace tactus::hil {

struct DeviceUnderTest {
  hal::AnyDevice& device;
  std::string identity;
  HilOptions options;
  std::vector<hal::NotChecked> not_checked{};  // these two as of hal::OpenedDevice
  std::function<std::string()> trouble{};
};

std::span<const Check> device_checks() noexcept;

// `request.only`: names of device_checks().
SuiteReport run_device_suite(DeviceUnderTest& under_test, const SuiteRequest& request, const SuiteHooks& hooks);

}  // namespace tactus::hil
