// The budget file: round trip, and which runs it refuses.
#include "tools/timing/budget.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/tools/timing/made_ticks.h"

using Catch::Matchers::Contains;

using namespace tactus;
using namespace tactus::timing;

namespace {

const Machine kHere{.cpu_model = "Some CPU",
                    .kernel = "6.1.0-rt #1",
                    .boot_line = "quiet isolcpus=3",
                    .governor = "performance",
                    .cores = 4};

std::string signed_off(TimingVerdict wanted = TimingVerdict::kGood) {
  TimingResult r{.statistics = TickStatistics({kPeriod_ns, 0, 10})};
  for (std::uint64_t i = 0; i < 1000; ++i) r.statistics.add_loop(usual_tick(i));
  if (wanted == TimingVerdict::kMachine) r.statistics.add_loop(woken_late(1000, 800'000));
  if (wanted == TimingVerdict::kBad) {
    auto t = usual_tick(1000);
    t.minor_faults = 1;
    r.statistics.add_loop(t);
  }
  r.statistics.finish();
  r.rows = judge(r.statistics);
  return budget_text(r, kHere);
}

Budget good_budget() {
  const auto budget = read_budget(signed_off(), "budget.json");
  INFO(budget.message());
  REQUIRE(budget.ok());
  return budget.value();
}

}  // namespace

TEST_CASE("a budget reads back as it was measured") {
  const Budget b = good_budget();
  CHECK(b.machine == kHere);
  CHECK(b.members == 40);
  CHECK(b.sub_steps == 4);
  CHECK(b.rate_Hz == 1000);
  CHECK(b.verdict == "good");
  CHECK(b.worst_us == Approx(189));  // 2 + 3 + 60 + 120 + 4
  CHECK(b.margin == Approx(1 - 0.189));
  CHECK(b.wake_p50_us > 0);
  CHECK(b.wake_p50_us <= b.wake_p99_9_us);
  CHECK(b.wake_p99_9_us <= b.wake_worst_us);
}

TEST_CASE("a bad run is not signed off") {
  CHECK(signed_off(TimingVerdict::kBad).empty());
  CHECK_FALSE(signed_off(TimingVerdict::kMachine).empty());
}

TEST_CASE("a budget that was edited, cut short or is something else is refused in one line") {
  std::string edited = signed_off();
  const auto at = edited.find("\"members\": 40");
  REQUIRE(at != std::string::npos);
  edited.replace(at, 13, "\"members\": 90");
  const struct {
    std::string text;
    const char* says;
  } cases[] = {{edited, "was changed after it was signed off"},
               {signed_off().substr(0, 200), "is no budget"},
               {"{\"rows\": []}", "is no budget"},
               {"", "is no budget"}};
  for (const auto& c : cases) {
    const auto budget = read_budget(c.text, "budget.json");
    REQUIRE_FALSE(budget.ok());
    CHECK_THAT(budget.message(), Catch::StartsWith("budget.json: ") && Contains(c.says) && Contains("accepted: "));
    CHECK(budget.message().find('\n') == std::string::npos);
  }
}

TEST_CASE("a run within the budget goes ahead, and one with more members with fewer") {
  CHECK(check_budget(good_budget(), kHere, {1000, 40, 4, 80}).refusal.empty());
  CHECK(check_budget(good_budget(), kHere, {500, 10, 2, 90}).note.empty());
  const auto answer = check_budget(good_budget(), kHere, {1000, 64, 4, 80});
  CHECK(answer.refusal.empty());
  CHECK(answer.fewer_members == 40u);
  CHECK_THAT(answer.note, Contains("64 members are asked for, 40 were measured"));
}

TEST_CASE("a run beyond what fewer members can lower, or on another machine, is refused with the difference") {
  const auto refusal = [](const Machine& machine, const BudgetRequest& request) {
    return check_budget(good_budget(), machine, request).refusal;
  };
  Machine cpu = kHere, kernel = kHere, boot = kHere, governor = kHere, cores = kHere;
  cpu.cpu_model = "Other CPU";
  kernel.kernel = "6.1.0";
  boot.boot_line = "quiet";
  governor.governor = "powersave";
  cores.cores = 2;
  CHECK_THAT(refusal(cpu, {}), Contains("CPU 'Some CPU', here it is 'Other CPU'"));
  CHECK_THAT(refusal(kernel, {}), Contains("kernel"));
  CHECK_THAT(refusal(boot, {}), Contains("boot line"));
  CHECK_THAT(refusal(governor, {}), Contains("frequency governor"));
  CHECK_THAT(refusal(cores, {}), Contains("number of cores '4', here it is '2'"));
  CHECK_THAT(refusal(kHere, {2000, 40, 4, 80}), Contains("2000 Hz are asked for, 1000 Hz were measured"));
  CHECK_THAT(refusal(kHere, {1000, 40, 8, 80}), Contains("8 sub-steps"));
  CHECK_THAT(refusal(kHere, {1000, 40, 4, 10}), Contains("priority 10"));
  const auto machine = read_budget(signed_off(TimingVerdict::kMachine), "b");
  REQUIRE(machine.ok());
  CHECK_THAT(check_budget(machine.value(), kHere, {}).refusal, Contains("with the verdict 'machine'"));
}
