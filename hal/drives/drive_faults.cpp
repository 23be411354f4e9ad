#include "hal/drives/drive_faults.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <span>
#include <string_view>

#include "hal/drives/odrive_codec.h"
#include "hal/kinematics/tool_kinematics.h"

namespace tactus::hal {
namespace {

constexpr unsigned kFamilyShift = 8, kCodeShift = 12;
constexpr std::uint32_t kLargestCode = (kOfHost >> kCodeShift) - 1;
constexpr std::uint32_t kNeverEnabled = 0x80;  // in the place of a DriveMode

constexpr std::uint32_t compose(std::uint32_t number, DriveFamily family, std::uint32_t code) noexcept {
  return number | (static_cast<std::uint32_t>(family) + 1) << kFamilyShift | code << kCodeShift;
}

constexpr std::uint32_t code_of(std::uint32_t fault) noexcept { return fault >> kCodeShift & kLargestCode; }

struct CodeWords {
  std::uint32_t code;
  std::string_view words;
};
constexpr CodeWords kDamiao[] = {{8, "over-voltage"},     {9, "under-voltage"},   {0xa, "over-current"},
                                 {0xb, "MOSFET too hot"}, {0xc, "rotor too hot"}, {0xd, "its host was silent"},
                                 {0xe, "overload"}};
constexpr CodeWords kCubeMars[] = {{1, "too hot"},       {2, "over-current"}, {3, "over-voltage"},
                                   {4, "under-voltage"}, {5, "encoder"},      {6, "phase unbalance"}};
constexpr CodeWords kRobStride[] = {{1, "under-voltage"}, {2, "over-current"},     {4, "too hot"},
                                    {8, "encoder"},       {0x10, "stall or Hall"}, {0x20, "not calibrated"}};
constexpr CodeWords kMoteus[] = {{32, "calibration: its encoder saw no magnet, or a current sensor has a wrong zero"},
                                 {33, "motor driver: most often the supply broke down under its load"},
                                 {34, "over-voltage: above servo.max_voltage, as when a supply takes no current back"},
                                 {35, "encoder: no magnet by its readings"},
                                 {36, "the motor is not calibrated"},
                                 {37, "a PWM cycle overran: its firmware"},
                                 {38, "too hot"},
                                 {39, "started outside of servopos.position_min and position_max"},
                                 {40, "under-voltage"},
                                 {41, "its configuration was changed while it ran"},
                                 {42, "no valid commutation encoder"},
                                 {43, "no valid output encoder"},
                                 {44, "its gate driver could not be enabled"},
                                 {45, "a stop position with limits, which is not used here: another program drives it"},
                                 {46, "timing: its firmware"},
                                 {47, "servo.bemf_feedforward without an acceleration limit; set it to 0"},
                                 {48, "servopos.position_min or position_max is out of its range"}};
constexpr CodeWords kOdrive[] = {{kOdriveWatchdog05, "its watchdog, with firmware 0.5"},
                                 {kOdriveWatchdog06, "its watchdog, with 0.6"}};

struct FamilyCodes {
  std::string_view what;
  bool bits;
  std::span<const CodeWords> words;  // a code that is not listed is explained in the maker's manual only
};

FamilyCodes codes_of(DriveFamily family) noexcept {
  switch (family) {
    case DriveFamily::kDamiao:
      return {"status", false, kDamiao};
    case DriveFamily::kRobStride:
      return {"fault bits", true, kRobStride};
    case DriveFamily::kMoteus:
      return {"fault", false, kMoteus};
    case DriveFamily::kOdrive:
      return {"error bits", true, kOdrive};
    default:
      return {"error", false, kCubeMars};
  }
}

// `told`: a DriveMode, or kNeverEnabled.
std::string describe_left_force(unsigned axis, std::uint32_t told) {
  if (told == kNeverEnabled)
    return fmt::format(
        "the drive of axis {} does not get enabled; look at its supply and its configuration, by the maker's manual, "
        "then re-arm",
        axis);
  const std::string text = fmt::format("the drive of axis {} is not enabled any more: ", axis);
  switch (static_cast<DriveMode>(told)) {
    case DriveMode::kDisabled:
    case DriveMode::kStarting:
      return text + "it has restarted, or another program stopped it; look at supply and bus, then re-arm";
    case DriveMode::kTimedOut:
      return text + "its watchdog acted, since no command reached it; look at bus and the host's load, then re-arm";
    case DriveMode::kOther:
      return text + "it is in a mode that another program chose; end that program, then re-arm";
    default:
      return text + "its watchdog, its supply or another program; look at supply and bus, then re-arm";
  }
}

}  // namespace

std::uint32_t drive_fault_of(unsigned axis, DriveFamily family, std::uint32_t code) noexcept {
  const std::uint32_t kept =
      codes_of(family).bits ? static_cast<std::uint32_t>(std::countr_zero(code)) + 1 : code & kLargestCode;
  return compose(kDriveReportsFault + axis, family, kept);
}

std::uint32_t drive_left_force(unsigned axis, DriveFamily family, DriveMode told) noexcept {
  return compose(kDriveLeftForce + axis, family, static_cast<std::uint32_t>(told));
}

std::uint32_t drive_never_enabled(unsigned axis, DriveFamily family) noexcept {
  return compose(kDriveLeftForce + axis, family, kNeverEnabled);
}

std::string describe_drive_code(DriveFamily family, std::uint32_t code) {
  const FamilyCodes codes = codes_of(family);
  std::string text = codes.bits ? fmt::format("{} {:#x}", codes.what, code) : fmt::format("{} {}", codes.what, code);
  for (const CodeWords& known : codes.words)
    if (codes.bits ? (code & known.code) != 0 : code == known.code) text += fmt::format(", {}", known.words);
  return text;
}

std::string describe_drive_fault(std::uint32_t fault) {
  const std::uint32_t number = number_of_drive_fault(fault);
  const auto in = [number](std::uint32_t first) { return number >= first && number < first + kAxisCount; };
  if (in(kDriveReportsFault)) {
    std::string said = "a fault";
    if (const std::uint32_t family = fault >> kFamilyShift & 0xfu; family >= 1 && family <= kDriveFamilies) {
      const auto of = static_cast<DriveFamily>(family - 1);
      const std::uint32_t kept = code_of(fault);
      const bool bit = codes_of(of).bits && kept >= 1 && kept <= 32;
      said = "a fault: " + describe_drive_code(of, bit ? 1u << (kept - 1) : kept);
    }
    return fmt::format("the drive of axis {} reports {}; mend what it names, by the maker's manual, then re-arm",
                       number - kDriveReportsFault, said);
  }
  if (in(kDriveLeftForce)) return describe_left_force(number - kDriveLeftForce, code_of(fault));
  if (fault != number) return {};
  if (in(kDriveSilent))
    return fmt::format("the drive of axis {} does not answer; look at its cable and supply, then re-arm",
                       number - kDriveSilent);
  if (in(kDriveLacksTorque))
    return fmt::format(
        "the drive of axis {} answers without the torque that it is sent: it has restarted or timed out, it is at a "
        "limit of its own, or torque_range_Nm is not its; look at supply and limits, then re-arm",
        number - kDriveLacksTorque);
  return {};
}

}  // namespace tactus::hal
