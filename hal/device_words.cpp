#include "hal/device_words.h"

#include <fmt/format.h>

#include <string_view>

#include "firmware/faults.h"
#include "hal/drives/drive_faults.h"
#include "hal/falcon/falcon_faults.h"
#include "hal/host_faults.h"
#include "hal/sdk/sdk_faults.h"

namespace tactus::hal {
namespace {

std::string_view words_of(firmware::Fault fault) noexcept {
  using firmware::Fault;
  switch (fault) {
    case Fault::kNone:
      return {};
    case Fault::kCommandsLost:
      return "it missed commands until its watchdog braked; look at the link and the host's load, then re-arm";
    case Fault::kEmergencyStop:
      return "its emergency stop is pressed; release it, then re-arm";
    case Fault::kOverspeed:
      return "an axis moved faster than its max_speed: a run-away, or an encoder that jumps; re-arm, and if it returns "
             "check the encoder";
    case Fault::kEffortNotFinite:
      return "a command with NaN or infinity came: a mistake in the host's program; keep the recording and report it";
    case Fault::kMotorBus:
      return "the motors' supply failed; restore it, then re-arm";
    case Fault::kBadConfiguration:
      return "its configuration makes no sense; write registers until it does or execute `factory`, then re-arm";
    case Fault::kEncoder:
      return "an encoder has a line fault, an impossible transition or a wrong index pulse; mend it, re-arm, home";
    case Fault::kOverheated:
      return "a motor winding is at its temperature limit; let it cool, then re-arm";
    case Fault::kSelfTest:
      return "its self-test failed; write any register or execute `factory`, re-arm, and if it returns the device is "
             "broken";
  }
  return "this program does not know it; see the device's manual, clear it, then re-arm";
}

struct LimitWords {
  firmware::Limit limit;
  std::string_view words;
};
constexpr LimitWords kLimits[] = {
    {firmware::Limit::kFading, "it misses commands, its effort fades"},
    {firmware::Limit::kEmergencyStop, "its emergency stop is pressed: release it"},
    {firmware::Limit::kMotorBusLow, "the motors' supply is not good: restore it"},
    {firmware::Limit::kWarm, "a motor winding is warm: let it cool"},
    {firmware::Limit::kNotHomed, "homing is demanded and not done: home it"},
    {firmware::Limit::kHoming, "homing is under way: end it"},
    {firmware::Limit::kIdleFirst, "it has started and waits for a command that wants IDLE: re-arm"},
};

}  // namespace

std::string name_of(haptics::DeviceState state) {
  constexpr std::string_view kNames[] = {"RESET", "IDLE", "FORCE", "BRAKE"};
  const auto number = static_cast<std::uint32_t>(state);
  return number < std::size(kNames) ? std::string(kNames[number]) : fmt::format("state {}", number);
}

std::string describe_device_fault(std::uint32_t number) {
  if (number == 0) return {};
  const auto told = [number](std::string_view words) {
    return fmt::format("device fault {}: {}", shown_fault(number), words);
  };
  if ((number & kOfHost) == 0) return told(words_of(static_cast<firmware::Fault>(number)));
  if (const std::string drive = describe_drive_fault(number); !drive.empty()) return told(drive);
  if (const std::string library = describe_sdk_fault(number); !library.empty()) return told(library);
  return told(describe_falcon_fault(number));
}

std::string describe_device_limits(std::uint32_t limits) {
  std::string text;
  constexpr unsigned kFirst = firmware::kFirstLimit;
  for (unsigned number = static_cast<unsigned>(firmware::Limit::kFading); number <= firmware::kLastLimit; ++number) {
    if (((limits >> (number - kFirst)) & 1u) == 0) continue;
    std::string_view words = "this program does not know it";
    for (const LimitWords& known : kLimits)
      if (static_cast<unsigned>(known.limit) == number) words = known.words;
    text += fmt::format("{}limit {}: {}", text.empty() ? "" : "; ", number, words);
  }
  return text;
}

std::string describe(Fault fault, const DeviceReport& device) {
  if (fault == Fault::kDeviceFault && device.fault != 0) return describe_device_fault(device.fault);
  std::string text(tactus::describe(fault));
  if (fault == Fault::kNone) return text;
  const bool of_state =
      fault == Fault::kDeviceBrake || fault == Fault::kDeviceLeftForce || fault == Fault::kForceRefused;
  if (of_state && fault != Fault::kDeviceBrake) text += fmt::format(" (it is in {})", name_of(device.state));
  // An emergency stop that host and device saw has the same words of both.
  const bool said =
      fault == Fault::kEmergencyStop && device.fault == static_cast<std::uint32_t>(firmware::Fault::kEmergencyStop);
  if (device.fault != 0 && !said) text += "; " + describe_device_fault(device.fault);
  if (of_state && device.limits != 0)
    if (const std::string limits = describe_device_limits(device.limits); !limits.empty()) text += "; " + limits;
  return text;
}

}  // namespace tactus::hal
