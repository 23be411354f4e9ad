// Budget file: certifies what a timing run measured on this PC, and limits later runs to it.
//
// A budget holds the machine (CPU, kernel, boot line, settings of the core), the measurement (rate, members, sub-steps,
// histogram of computing time) and the remaining margin of the period. An edit invalidates its seal, a checksum over
// the rest of the file; this protects against mistakes, not against an adversary.
// `tactus run --budget` compares, in this order: the seal; the machine (another one: refused); the verdict; the rate
// (a higher one: refused); sub-steps (more: refused, as they are the scene's accuracy); members (more: the cap is
// lowered to the certified number, and one line reports it). Thread: normal. Units in the keys.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "rt/base/result.h"
#include "tools/timing/run_timing.h"

namespace tactus::timing {

// The machine for which a budget is valid.
struct Machine {
  std::string cpu_model, kernel, boot_line, governor;
  unsigned cores{0};
  bool operator==(const Machine&) const = default;
};
Machine this_machine(int cpu);

// The file's text. Empty if the run's verdict is bad.
std::string budget_text(const TimingResult& result, const Machine& machine);

struct Budget {
  Machine machine;
  double rate_Hz{0}, worst_us{0}, margin{0};  // worst computing time; share of the period left by the worst tick
  double wake_p50_us{0}, wake_p99_9_us{0}, wake_worst_us{0};  // wake-up latency of the loop
  unsigned members{0}, sub_steps{0};
  int priority{0};
  std::string verdict;
};
// Error, one line: the file, what is wrong, what is accepted.
Result<Budget> read_budget(const std::string& text, const std::string& name);
Result<Budget> load_budget(const std::string& path);

// The capacity that a run requests of the budget.
struct BudgetRequest {
  double rate_Hz{1000};
  unsigned members{64}, sub_steps{4};
  int priority{80};
};
struct BudgetAnswer {
  std::string refusal;                    // one line; empty: it may run
  std::optional<unsigned> fewer_members;  // the cap to run with
  std::string note;                       // one line, if it runs with less than requested
};
BudgetAnswer check_budget(const Budget& budget, const Machine& machine, const BudgetRequest& request);

}  // namespace tactus::timing
