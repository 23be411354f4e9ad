#include "tools/hil/check.h"

#include <iterator>

namespace tactus::hil {
namespace {

// Name, what, needs, function.
constexpr Check kChecks[] = {
    {"identity", "protocol, firmware and class are what the description says", kNothing, check_identity},
    {"registers", "every register is readable and in its range; wrong questions are refused", kNothing,
     check_registers},
    {"losses", "at rest: frames lost, late, reordered, duplicated, broken", kNothing, check_losses},
    {"round-trip", "from a command to the state frame that says the device has it", kNothing, check_round_trip},
    {"force-age", "from the device's sample to the effort that answers it, by the device's clock", kNothing,
     check_force_age},
    {"clock", "the device's period, and its clock against the host's", kNothing, check_clock},
    {"watchdog", "commands stop: after how many frames it fades and brakes; latched until a re-arm", kMotors,
     check_watchdog},
    {"brake", "BRAKE is obeyed at once, and left by a re-arm's rise alone", kMotors, check_brake},
    {"not-finite", "a command with NaN: BRAKE, and the fault is named", kMotors, check_not_finite},
    {"broken-commands", "commands with a wrong checksum feed no watchdog", kMotors, check_broken_commands},
    {"repeated-commands", "the same command again and again feeds no watchdog", kMotors, check_repeated_commands},
    {"saturation", "a force above the limit is cut and reported; the limit is set to zero for it", kMotors,
     check_saturation},
    {"force", "short pushes of --force along each axis: no fault, and the tool does not go the wrong way",
     kMotors | kForce, check_force},
    {"e-stop", "from the e-stop to zero force; latched until a re-arm", kMotors, check_emergency_stop},
    {"unplug", "the device goes away and comes back", kMotors, check_unplug},
    {"broken-states", "state frames with a wrong checksum are refused and counted", kMotors, check_broken_states},
    {"bus-off", "the CAN controller leaves the bus and comes back", kMotors, check_bus_off},
    {"soak", "every frame accounted for, at the full rate", kSoak, check_soak},
};

}  // namespace

std::span<const Check> all_checks() noexcept { return kChecks; }

CheckFinding bad(std::string reason, std::string threshold) {
  return {.verdict = CheckVerdict::kBad,
          .measured = {},
          .threshold = std::move(threshold),
          .reason = std::move(reason),
          .figures = {}};
}
CheckFinding skipped(std::string reason) {
  return {
      .verdict = CheckVerdict::kSkipped, .measured = {}, .threshold = {}, .reason = std::move(reason), .figures = {}};
}

}  // namespace tactus::hil
