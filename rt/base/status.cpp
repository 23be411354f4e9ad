#include "rt/base/status.h"

namespace tactus {

std::string_view describe(Fault fault) noexcept {
  switch (fault) {
    case Fault::kNone:
      return "no fault";
    case Fault::kLinkLost:
      return "link lost: 10 frames in a row are missing; check the cable and the device's power, then re-arm";
    case Fault::kDeviceUnplugged:
      return "device unplugged: the link reports it gone; plug it in, then re-arm";
    case Fault::kInputNotFinite:
      return "device sent NaN or infinity 3 times in a row; check its calibration, then re-arm";
    case Fault::kInputRotation:
      return "device sent a rotation that is none 3 times in a row (norm off 1 by over 1e-3); calibrate it, then "
             "re-arm";
    case Fault::kInputWorkspace:
      return "device reports a place outside its workspace 3 times in a row; home or calibrate it, then re-arm";
    case Fault::kInputJump:
      return "device moved faster than it can 3 times in a row; check its encoders, then re-arm";
    case Fault::kInputStale:
      return "device repeats its frame: sequence or time stood still 10 times in a row; reset the device, then re-arm";
    case Fault::kDeviceBrake:
      return "device is in BRAKE: its watchdog or its own limits stopped it; find the cause, then re-arm";
    case Fault::kDeviceFault:
      return "device reports a fault of its own, by number; clear its cause, then re-arm";
    case Fault::kOutputNotFinite:
      return "computed force was not finite: an error of this program; keep the recording and report it";
    case Fault::kEmergencyStop:
      return "emergency stop is pressed; release it, then re-arm";
    case Fault::kWorldLost:
      return "global world lost (reserved: no release raises it)";
    case Fault::kDeviceLeftForce:
      return "device left FORCE by itself: it was reset, or another program commands it; find the cause, then re-arm";
    case Fault::kForceRefused:
      return "device refuses FORCE: it is not homed, its supply is missing, or it starts; remove the cause, then "
             "re-arm";
  }
  return "unknown fault number: the recording is from a newer release";
}

std::string_view name_of(StatusBit bit) noexcept {
  switch (bit) {
    case kFrameMissing:
      return "frame-missing";
    case kForceFading:
      return "force-fading";
    case kInputRejected:
      return "input-rejected";
    case kForceSaturated:
      return "force-saturated";
    case kSlewLimited:
      return "slew-limited";
    case kPassivityActive:
      return "passivity-active";
    case kWorldLate:
      return "world-late";
    case kBorderFrozen:
      return "border-frozen";
    case kWorldFade:
      return "world-fade";
    case kSolverCut:
      return "solver-cut";
    case kSubStepsReduced:
      return "sub-steps-reduced";
    case kCapacityExceeded:
      return "capacity-exceeded";
    case kNotArmed:
      return "not-armed";
    case kProxyContact:
      return "proxy-contact";
    case kBorderSpent:
      return "border-spent";
    case kSceneReset:
      return "scene-reset";
  }
  return {};
}

}  // namespace tactus
