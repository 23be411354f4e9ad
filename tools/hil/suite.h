// Runs checks one after the other and collects their findings.
// Thread: normal.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tools/hil/check.h"

namespace tactus::hil {

struct CheckReport {
  const Check* check{nullptr};
  CheckFinding finding;
  double took_s{0};
};

struct SuiteReport {
  std::string device, identity;
  std::string left_in;  // the device's state at the end, and why, where the suite says so
  std::vector<CheckReport> checks;
  loop::SetupReport setup;  // real time only
  bool real_time{false};

  std::size_t count(CheckVerdict verdict) const noexcept;
  // No check is bad, and at least one is good.
  bool good() const noexcept { return count(CheckVerdict::kBad) == 0 && count(CheckVerdict::kGood) > 0; }
  bool degraded() const noexcept { return real_time && setup.failed(); }
};

struct SuiteRequest {
  std::vector<std::string> only;  // names; empty: all
  bool motors_allowed{false};     // the operator agreed
};

struct SuiteHooks {
  std::function<void(const Check&, double share)> progress;
  std::function<void(const CheckReport&)> done;
  std::function<bool()> stop;  // called between two checks
};

// The names that are none of these checks, in quotes; empty if all exist.
std::string unknown_checks(const std::vector<std::string>& names, std::span<const Check> checks);

// The requested checks, in the table's order.
std::vector<const Check*> chosen_checks(const std::vector<std::string>& only);

SuiteReport run_suite(Bench& bench, const SuiteRequest& request, const SuiteHooks& hooks);

// --- tools/hil/report.cpp
std::string to_line(const CheckReport& report);
std::string to_text(const SuiteReport& report);
std::string to_json_text(const SuiteReport& report);
std::string to_junit(const SuiteReport& report);

}  // namespace tactus::hil
