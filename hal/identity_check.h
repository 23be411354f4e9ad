// Checks, before a device on a link is driven, that it matches its description.
//
// Compares the protocol, the device class if it reports one, the control period and the watchdog's frame counts. For
// every axis of the description: the encoder's quantum must agree, because the pose is computed from it; the effort
// limit must allow what the description promises and little more, because it is the last guard; the speed limit must
// not brake motions that the description allows. The norm limits max_force and max_torque are checked like the effort
// limits. Units: SI. Thread: [setup], [normal]; never the haptic thread. Bound: about thirty requests of at most
// `patience` each; the first without a reply ends the check.
#pragma once

#include <fmt/format.h>

#include <bit>
#include <cmath>

#include "firmware/identity.h"
#include "firmware/registers.h"
#include "hal/frame_link.h"
#include "hal/profiles.h"

namespace tactus::hal {

// Largest accepted ratio of an effort limit to what the description needs: a looser limit does not guard this device.
inline constexpr double kMaxSpareEffort = 1.5;
// Relative: registers are floats, possibly typed by hand.
inline constexpr double kQuantumTolerance = 1e-5, kLimitTolerance = 1e-3;

template <FrameLink Link>
class IdentityCheck {
 public:
  IdentityCheck(const DeviceProfile& profile, std::uint32_t period_us, Link& link, std::chrono::milliseconds patience)
      : profile_(profile), period_us_(period_us), link_(link), patience_(patience) {}

  Status run() {
    whole(firmware::number::kProtocol, "protocol version", firmware::kProtocolVersion, "update the device's firmware");
    check_class();
    whole(firmware::number::kPeriod, "control period [us]", period_us_, "run at the device's rate (--rate)");
    const firmware::Config standard;
    whole(firmware::number::kFadeFrames, "missed frames until the force fades", standard.fade_frames, kCorrect);
    whole(firmware::number::kBrakeFrames, "missed frames until the brake", standard.brake_frames, kCorrect);
    const AxisKinds axes = axes_of(profile_.description.kind);
    for (unsigned axis = 0; axis < axes.prismatic + axes.rotary; ++axis) check_axis(axis);
    const firmware::Config expected = firmware_config(profile_, period_us_);
    check_norm(firmware::number::kMaxForce, "max_force (norm of axes 0 to 2)", expected.max_force_N);
    if (profile_.description.has_rotation())
      check_norm(firmware::number::kMaxTorque, "max_torque (norm of axes 3 to 5)", expected.max_torque_Nm);
    return status_;
  }

 private:
  static constexpr const char* kCorrect = "write the register, or name the description of this device (--device-file)";

  void check_class() {
    const std::uint32_t told = read(firmware::number::kDeviceClass);
    const auto device_class = static_cast<firmware::MechanismClass>(told);
    const bool has_rotation = profile_.description.has_rotation();
    const bool other = (device_class == firmware::MechanismClass::kDesk3 && has_rotation) ||
                       (device_class == firmware::MechanismClass::kVirtuose6 && !has_rotation);
    if (other) fail("device class", told, has_rotation ? 2 : 1, "name the description of this device (--device-file)");
  }

  void check_axis(unsigned axis) {
    const firmware::Config expected = firmware_config(profile_, period_us_);
    const auto number = [axis](std::uint16_t first) { return static_cast<std::uint16_t>(first + axis); };
    const auto named = [axis](const char* what) { return fmt::format("{} of axis {}", what, axis); };
    const double quantum = real(number(firmware::number::kQuantum)), described = profile_.quantum[axis];
    if (!(std::abs(quantum - described) <= kQuantumTolerance * described))
      fail(named("quantum"), quantum, described, kCorrect);
    const double effort = real(number(firmware::number::kMaxEffort)), needed = profile_.bounds.effort[axis];
    if (!(effort >= needed * (1.0 - kLimitTolerance) && effort <= kMaxSpareEffort * needed))
      fail(named("effort limit"), effort, static_cast<double>(expected.max_effort[axis]), kCorrect);
    const double speed = real(number(firmware::number::kMaxSpeed)), fastest = profile_.bounds.rate[axis];
    if (!(speed >= fastest * (1.0 - kLimitTolerance)))
      fail(named("speed limit"), speed, static_cast<double>(expected.max_speed[axis]), kCorrect);
  }

  // N, or N m where the axes are rotary. `expected` is kFirmwareMargin times what the description needs.
  void check_norm(std::uint16_t number, const char* what, float expected) {
    const double told = real(number), described = static_cast<double>(expected), needed = described / kFirmwareMargin;
    if (!(told >= needed * (1.0 - kLimitTolerance) && told <= kMaxSpareEffort * needed))
      fail(what, told, described, kCorrect);
  }

  void whole(std::uint16_t number, const char* what, std::uint32_t described, const char* advice) {
    const std::uint32_t told = read(number);
    if (told != described) fail(what, told, described, advice);
  }

  double real(std::uint16_t number) { return static_cast<double>(std::bit_cast<float>(read(number))); }

  // Returns 0 once a check has failed: only the first failure is reported.
  std::uint32_t read(std::uint16_t number) {
    if (!status_.ok()) return 0;
    const firmware::ServiceMessage request{.operation = firmware::Operation::kRead,
                                           .status = firmware::ServiceStatus::kGood,
                                           .tag = ++tag_,
                                           .address = number,
                                           .value = 0};
    const auto reply = link_.call(request, patience_);
    if (!reply.ok()) {
      status_ = reply.status();
    } else if (reply.value().status != firmware::ServiceStatus::kGood) {
      status_ = Status::error(fmt::format("device: register {:#06x} is not there (status {}); update its firmware",
                                          number, static_cast<unsigned>(reply.value().status)));
    } else {
      return reply.value().value;
    }
    return 0;
  }

  void fail(const std::string& what, double told, double described, const char* advice) {
    if (!status_.ok()) return;
    status_ = Status::error(fmt::format("device: its {} is {:.9g}, the description {} has {:.9g}; {}", what, told,
                                        profile_.name, described, advice));
  }

  const DeviceProfile& profile_;
  std::uint32_t period_us_;
  Link& link_;
  std::chrono::milliseconds patience_;
  std::uint8_t tag_{0};
  Status status_{Status::good()};
};

// An error is one line: the device's value, the description's value, what to do.
template <FrameLink Link>
Status check_identity(const DeviceProfile& profile, std::uint32_t period_us, Link& link,
                      std::chrono::milliseconds patience = std::chrono::milliseconds(100)) {
  return IdentityCheck<Link>(profile, period_us, link, patience).run();
}

}  // namespace tactus::hal
