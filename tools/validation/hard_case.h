// A hard case: a small world with a known answer, run at an accuracy and a step length, and scored by its error.
//
// Each metric has an error and a tolerance; its score is 1 up to the tolerance and drops by 0.5 for each factor of ten
// beyond it. The score of a case is that of its worst metric. A case passes if every metric is within its tolerance; it
// scores 0 if a gate fails: a value that is not finite, an unexplained energy gain, an allocation in a step, work left
// out, a different state in the second run. The sources of expected values are listed in
// tests/tools/validation/README.md.
// Thread: one. Units: SI, in the names.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace tactus::hard_cases {

enum class Accuracy { kFast, kBalanced, kAccurate };
inline constexpr Accuracy kAccuracies[] = {Accuracy::kFast, Accuracy::kBalanced, Accuracy::kAccurate};
std::string_view name_of(Accuracy accuracy) noexcept;

struct Setting {
  Accuracy accuracy{Accuracy::kBalanced};
  double step_s{1e-3};
};
// Sub-steps per step of 1 ms / 10 ms: fast 2 / 10, balanced 4 / 40, accurate 16 / 160.
unsigned sub_steps_of(const Setting& setting) noexcept;

struct Metric {
  std::string name;
  double observed{0}, expected{0};
  double error{0}, tolerance{0};

  bool within() const noexcept { return error <= tolerance; }  // NaN is not
  double score() const noexcept;
};

struct Outcome {
  std::vector<Metric> metrics;
  std::vector<std::string> broken_gates;
  std::uint64_t hash{0};  // of the final state

  void near(std::string name, double observed, double expected, double tolerance);
  void relative(std::string name, double observed, double expected, double tolerance);  // of `expected`
  void at_most(std::string name, double observed, double bound);  // the error is the observed value
  void holds(std::string name, bool does);                        // all or nothing
  void gate(std::string name, bool holds);

  double score() const noexcept;
  bool passed() const noexcept;
};

// A metric that is known to be beyond its tolerance, and its largest error.
struct Miss {
  std::string_view metric;
  double most_error;
};

struct HardCase {
  int number;             // in the list of the README; cases beyond it are numbered from 101
  std::string_view name;  // "twenty cubes on each other"
  bool global_step;       // also in steps of 10 ms
  Outcome (*run)(const Setting& setting);
  // Known reason for failing at balanced accuracy in steps of 1 ms and of 10 ms; empty: it passes.
  std::string_view fails_because{}, fails_in_10_ms_because{};
  // The metrics that fail then, all of them, in the steps that have a reason above.
  std::vector<Miss> misses{};

  std::string_view why_it_fails(double step_s) const noexcept {
    return step_s > 5e-3 ? fails_in_10_ms_because : fails_because;
  }
};

// All cases, by number.
const std::vector<HardCase>& hard_cases();

// Runs the case twice and adds the gate that both final states are equal.
Outcome run_twice(const HardCase& one, const Setting& setting);

}  // namespace tactus::hard_cases
