#include "tools/hil/suite.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

namespace tactus::hil {
namespace {

CheckFinding run_one(Bench& bench, const Check& check, const SuiteRequest& request) {
  if ((check.needs & kMotors) != 0 && !request.motors_allowed)
    return skipped("it switches the motors on: agree, or give --yes");
  if ((check.needs & kForce) != 0 && bench.options().force_N <= 0) return skipped("it moves the tool: give --force N");
  if ((check.needs & kSoak) != 0 && bench.options().soak_frames == 0)
    return skipped("it takes ten minutes: give --soak, or --soak-frames N");
  if (const Status status = bench.settle(); !status.ok()) return bad(status.message());
  CheckFinding finding = check.run(bench);
  if (!request.motors_allowed) return finding;
  const Status after = bench.settle();
  if (!after.ok() && finding.verdict == CheckVerdict::kGood) {
    finding.verdict = CheckVerdict::kBad;
    finding.reason = "afterwards " + after.message();
  }
  return finding;
}

bool is_chosen(const std::vector<std::string>& only, const Check& check) {
  return only.empty() || std::find(only.begin(), only.end(), check.name) != only.end();
}

}  // namespace

std::size_t SuiteReport::count(CheckVerdict verdict) const noexcept {
  return static_cast<std::size_t>(std::count_if(
      checks.begin(), checks.end(), [&](const CheckReport& report) { return report.finding.verdict == verdict; }));
}

std::string unknown_checks(const std::vector<std::string>& names, std::span<const Check> checks) {
  std::string unknown;
  for (const std::string& name : names) {
    if (std::any_of(checks.begin(), checks.end(), [&](const Check& check) { return name == check.name; })) continue;
    unknown += fmt::format("{}'{}'", unknown.empty() ? "" : ", ", name);
  }
  return unknown;
}

std::vector<const Check*> chosen_checks(const std::vector<std::string>& only) {
  std::vector<const Check*> chosen;
  for (const Check& check : all_checks())
    if (is_chosen(only, check)) chosen.push_back(&check);
  return chosen;
}

SuiteReport run_suite(Bench& bench, const SuiteRequest& request, const SuiteHooks& hooks) {
  SuiteReport report;
  report.real_time = !bench.options().stepped;
  for (const Check* check : chosen_checks(request.only)) {
    if (hooks.stop && hooks.stop()) break;
    bench.on_progress([&](double share) {
      if (hooks.progress) hooks.progress(*check, share);
    });
    const auto began = std::chrono::steady_clock::now();
    CheckReport one{check, run_one(bench, *check, request), 0};
    one.took_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    if (check == &all_checks().front()) report.identity = one.finding.measured;
    if (hooks.done) hooks.done(one);
    report.checks.push_back(std::move(one));
  }
  report.setup = bench.setup();
  return report;
}

}  // namespace tactus::hil
