#include "tools/validation/hard_case.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tactus::hard_cases {

std::string_view name_of(Accuracy accuracy) noexcept {
  switch (accuracy) {
    case Accuracy::kFast:
      return "fast";
    case Accuracy::kBalanced:
      return "balanced";
    case Accuracy::kAccurate:
      return "accurate";
  }
  return "";
}

unsigned sub_steps_of(const Setting& setting) noexcept {
  const bool global = setting.step_s > 5e-3;
  switch (setting.accuracy) {
    case Accuracy::kFast:
      return global ? 10 : 2;
    case Accuracy::kBalanced:
      return global ? 40 : 4;
    case Accuracy::kAccurate:
      return global ? 160 : 16;
  }
  return 0;
}

double Metric::score() const noexcept {
  if (within()) return 1;
  if (!std::isfinite(error) || !(tolerance > 0)) return 0;
  return std::clamp(1 - 0.5 * std::log10(error / tolerance), 0.0, 1.0);
}

void Outcome::near(std::string name, double observed, double expected, double tolerance) {
  metrics.push_back({.name = std::move(name),
                     .observed = observed,
                     .expected = expected,
                     .error = std::abs(observed - expected),
                     .tolerance = tolerance});
}

void Outcome::relative(std::string name, double observed, double expected, double tolerance) {
  metrics.push_back({.name = std::move(name),
                     .observed = observed,
                     .expected = expected,
                     .error = std::abs(observed / expected - 1),
                     .tolerance = tolerance});
}

void Outcome::at_most(std::string name, double observed, double bound) {
  metrics.push_back({.name = std::move(name),
                     .observed = observed,
                     .expected = 0,
                     .error = std::max(observed, 0.0),
                     .tolerance = bound});
  if (!std::isfinite(observed)) metrics.back().error = std::numeric_limits<double>::infinity();
}

void Outcome::holds(std::string name, bool does) {
  metrics.push_back({.name = std::move(name),
                     .observed = does ? 1.0 : 0.0,
                     .expected = 1,
                     .error = does ? 0 : std::numeric_limits<double>::infinity(),
                     .tolerance = 1});
}

void Outcome::gate(std::string name, bool holds) {
  if (!holds) broken_gates.push_back(std::move(name));
}

double Outcome::score() const noexcept {
  if (!broken_gates.empty() || metrics.empty()) return 0;
  double least = 1;
  for (const Metric& metric : metrics) least = std::min(least, metric.score());
  return least;
}

bool Outcome::passed() const noexcept {
  return broken_gates.empty() && !metrics.empty() &&
         std::all_of(metrics.begin(), metrics.end(), [](const Metric& metric) { return metric.within(); });
}

Outcome run_twice(const HardCase& one, const Setting& setting) {
  Outcome outcome = one.run(setting);
  outcome.gate("same state twice", one.run(setting).hash == outcome.hash);
  return outcome;
}

}  // namespace tactus::hard_cases
