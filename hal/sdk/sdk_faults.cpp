#include "hal/sdk/sdk_faults.h"

namespace tactus::hal {

std::string describe_sdk_fault(std::uint32_t number) {
  switch (number) {
    case kSdkNotCalibrated:
      return "its library says that it is not calibrated; put the stylus into the inkwell for a moment, or run the "
             "maker's diagnostic program, then re-arm";
    case kSdkMotorsWarm:
      return "its library says that the motors are warm; let it rest for some minutes, then re-arm";
    case kSdkForceTooLarge:
      return "its library refused a force as too large; lower the scene's stiffness or its limit, then re-arm";
    case kSdkForceTooSudden:
      return "its library refused a force that rose too fast; lower the scene's stiffness, then re-arm";
    case kSdkTooFast:
      return "its library says that the arm moved too fast; hold it, then re-arm";
    case kSdkForceError:
      return "its library gives no force and says no more; run the maker's diagnostic program, then re-arm";
    case kSdkDeviceFault:
      return "its library says that the device has a fault; switch it off and on, then start again";
    case kSdkConnectionLost:
      return "its library lost the device; look at its cable and supply, then start again";
    case kSdkLicenceRefused:
      return "its library refuses its licence; renew it with the maker's tool, then start again";
    case kSdkTimeWentBack:
      return "its library's clock ran backwards, so the age of its samples is not known; start again, and if it "
             "returns reinstall the maker's driver";
    case kSdkForcesOff:
      return "its library switched the forces off, or refuses them, and says no more: a button of the device, its own "
             "guard, or its supply; see its manual, then re-arm";
    default:
      return {};
  }
}

}  // namespace tactus::hal
