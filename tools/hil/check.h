// The suite's checks: one function each, grouped by topic in files, all in one table.
//
// A check receives a device in IDLE without fault, tests one property, and reports the measured value and its
// threshold. Thread: normal.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "tools/hil/bench.h"

namespace tactus::hil {

enum class CheckVerdict { kGood, kBad, kSkipped };

// One number, with its unit in the name.
struct Figure {
  std::string name;
  double value{0};
};

struct CheckFinding {
  CheckVerdict verdict{CheckVerdict::kGood};
  std::string measured;   // a line for people
  std::string threshold;  // limit it was compared with
  std::string reason;     // why bad or skipped
  std::vector<Figure> figures;
  std::string unseen{};  // what of it the device cannot show; empty: nothing
};

CheckFinding bad(std::string reason, std::string threshold = {});
CheckFinding skipped(std::string reason);

enum Need : unsigned {
  kNothing = 0,
  kMotors = 1,  // motors are on, or shorted: the operator must agree first
  kForce = 2,   // a force that moves the tool: --force
  kSoak = 4,    // takes long: --soak
};

struct Check {
  const char* name;
  const char* what;  // half a line for --list
  unsigned needs;
  CheckFinding (*run)(Bench&);
};

std::span<const Check> all_checks() noexcept;

// --- tools/hil/checks/
CheckFinding check_identity(Bench& bench);
CheckFinding check_registers(Bench& bench);
CheckFinding check_losses(Bench& bench);
CheckFinding check_round_trip(Bench& bench);
CheckFinding check_force_age(Bench& bench);
CheckFinding check_clock(Bench& bench);
CheckFinding check_watchdog(Bench& bench);
CheckFinding check_brake(Bench& bench);
CheckFinding check_not_finite(Bench& bench);
CheckFinding check_broken_commands(Bench& bench);
CheckFinding check_repeated_commands(Bench& bench);
CheckFinding check_saturation(Bench& bench);
CheckFinding check_force(Bench& bench);
CheckFinding check_emergency_stop(Bench& bench);
CheckFinding check_unplug(Bench& bench);
CheckFinding check_broken_states(Bench& bench);
CheckFinding check_bus_off(Bench& bench);
CheckFinding check_soak(Bench& bench);

}  // namespace tactus::hil
