// A hard case: a small world with a known answer, run at an accuracy and a step, graded by how near it comes.
//
// Each metric has an error and a tolerance; its score is 1 up to the tolerance and loses a half for each factor of ten
// beyond it. A case scores as its worst metric, passes when every metric is within its tolerance, and scores 0 when a
// gate breaks: something not finite, energy from nowhere, an allocation in a step, work left out, another state the
// second time. Where a value comes from is in tests/tools/validation/README.md.
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
// In a step: fast 2 in 1 ms and 10 in 10 ms, balanced 4 and 40, accurate 16 and 160.
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
  void at_most(std::string name, double observed, double bound);                        // the error is what is observed
  void holds(std::string name, bool does);                                              // all or nothing
  void gate(std::string name, bool holds);

  double score() const noexcept;
  bool passed() const noexcept;
};

struct HardCase {
  int number;             // in the list of the README; cases beyond it are numbered from 101
  std::string_view name;  // "twenty cubes on each other"
  bool global_step;       // also in steps of 10 ms
  Outcome (*run)(const Setting& setting);
  // Why it fails at the balanced accuracy in steps of 1 ms and of 10 ms; empty: it does not.
  std::string_view fails_because{}, fails_in_10_ms_because{};

  std::string_view why_it_fails(double step_s) const noexcept {
    return step_s > 5e-3 ? fails_in_10_ms_because : fails_because;
  }
};

// All there are, by number.
const std::vector<HardCase>& hard_cases();

// Runs it twice and adds the gate of equal states.
Outcome run_twice(const HardCase& one, const Setting& setting);

}  // namespace tactus::hard_cases
