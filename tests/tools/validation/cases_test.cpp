// Every hard case as a test of its own, at the balanced accuracy and each step that it has:
// tools/validation.
#include <algorithm>
#include <catch2/catch.hpp>
#include <string>

#include "tools/validation/hard_case.h"

using namespace tactus::hard_cases;

namespace {

// A metric is within its tolerance or a known miss, no larger than known; and what is known to miss does.
void check(const HardCase& one, const Setting& setting) {
  const Outcome outcome = run_twice(one, setting);
  const bool misses = !one.why_it_fails(setting.step_s).empty();
  std::size_t missed = 0;
  for (const std::string& gate : outcome.broken_gates) FAIL_CHECK("gate broken: " << gate);
  CHECK_FALSE(outcome.metrics.empty());
  for (const Metric& metric : outcome.metrics) {
    INFO(metric.name << ": " << metric.observed << ", expected " << metric.expected << ", error " << metric.error
                     << " of " << metric.tolerance << " allowed");
    const auto known = std::find_if(one.misses.begin(), one.misses.end(),
                                    [&](const Miss& miss) { return misses && miss.metric == metric.name; });
    if (known == one.misses.end()) {
      CHECK(metric.within());
    } else {
      ++missed;
      CHECK_FALSE(metric.within());
      CHECK(metric.error <= known->most_error);
    }
  }
  CHECK(missed == (misses ? one.misses.size() : 0));
  CHECK(one.misses.empty() == (one.fails_because.empty() && one.fails_in_10_ms_because.empty()));
}

class CaseInvoker final : public Catch::ITestInvoker {
 public:
  CaseInvoker(const HardCase& one, double step_s) : one_(one), step_s_(step_s) {}
  void invoke() const override { check(one_, {Accuracy::kBalanced, step_s_}); }

 private:
  const HardCase& one_;
  double step_s_;
};

// The table is known at start-up only, so the cases are registered here and not by TEST_CASE.
bool register_cases() {
  for (const HardCase& one : hard_cases())
    for (const double step_s : {1e-3, 1e-2}) {
      if (step_s > 5e-3 && !one.global_step) continue;
      const std::string name = std::to_string(one.number) + " " + std::string(one.name) +
                               (step_s > 5e-3 ? " in steps of 10 ms" : " in steps of 1 ms");
      // The sanitizers have enough with steps of 1 ms.
      const std::string tags = step_s > 5e-3 ? "[no-asan]" : "";
      const Catch::AutoReg registered(new CaseInvoker(one, step_s), CATCH_INTERNAL_LINEINFO, Catch::StringRef(),
                                      Catch::NameAndTags(name, tags));
    }
  return true;
}

const bool registered = register_cases();

}  // namespace

TEST_CASE("A metric loses half a point for each factor of ten beyond its tolerance") {
  const auto score = [](double error) { return Metric{"", 0, 0, error, 2}.score(); };
  CHECK(score(0) == 1);
  CHECK(score(2) == 1);
  CHECK(score(20) == Approx(0.5));
  CHECK(score(200) == Approx(0).margin(1e-12));
  CHECK(score(2e9) == 0);
  CHECK(score(std::numeric_limits<double>::quiet_NaN()) == 0);
}

TEST_CASE("A case with a broken gate or without a metric has not passed") {
  Outcome outcome;
  CHECK_FALSE(outcome.passed());
  outcome.at_most("speed", 1, 2);
  CHECK(outcome.passed());
  CHECK(outcome.score() == 1);
  outcome.gate("finite", false);
  CHECK_FALSE(outcome.passed());
  CHECK(outcome.score() == 0);
  CHECK(registered);
}

TEST_CASE("Every case of the list is in the table once") {
  for (int number = 1; number <= 44; ++number) {
    int found = 0;
    for (const HardCase& one : hard_cases()) found += one.number == number;
    INFO("case " << number);
    CHECK(found == 1);
  }
}
