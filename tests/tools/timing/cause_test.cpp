// Each cause of a late tick in synthetic records: the reported cause and its evidence.
#include "tools/timing/cause.h"

#include <catch2/catch.hpp>

#include "tests/tools/timing/made_ticks.h"

using Catch::Matchers::Contains;

using namespace tactus;
using namespace tactus::timing;

namespace {

constexpr Typical kUsual{5'000, 215'000, 30'000};

MachineChange quiet() { return {20'000'000, InterruptCounts{20, 0, 0}, 0, 0}; }

}  // namespace

TEST_CASE("a tick whose counts foresaw the time that it took is own work") {
  auto t = delayed_in_solve(1, 1'200'000);
  t.cpu_ns += 1'200'000;
  t.predicted_ns = 1'300'000;
  const auto a = attribute(t, kPeriod_ns, kUsual, quiet());
  CHECK(a.cause == Cause::kOwnWork);
  CHECK_THAT(a.evidence, Contains("1415 of them on its core, 1300 predicted") && Contains("40 members"));
}

TEST_CASE("a tick that began late is a late wake-up, with what the machine did then") {
  auto change = quiet();
  change.stolen_ms = 10;
  const auto a = attribute(woken_late(1, 900'000), kPeriod_ns, kUsual, change);
  CHECK(a.cause == Cause::kLateWake);
  CHECK_THAT(a.evidence, Contains("woke 905 us late, typically 5") && Contains("the bare timer up to 30") &&
                             Contains("its host took 10 ms"));
}

TEST_CASE("a tick that was interrupted has the cause that the kernel counted") {
  auto t = delayed_in_solve(1, 1'500'000);  // on its core for 215 us only

  SECTION("page faults before all else") {
    t.minor_faults = 2;
    t.involuntary_switches = 1;
    const auto a = attribute(t, kPeriod_ns, kUsual, quiet());
    CHECK(a.cause == Cause::kPageFault);
    CHECK_THAT(a.evidence, Contains("2 minor, 0 major"));
  }
  SECTION("a context switch where it was off its core") {
    t.involuntary_switches = 1;
    CHECK(attribute(t, kPeriod_ns, kUsual, quiet()).cause == Cause::kContextSwitch);
  }
  SECTION("a context switch that cost no time is none") {
    t.involuntary_switches = 1;
    t.cpu_ns = t.wrote_ns - t.woke_ns;
    CHECK(attribute(t, kPeriod_ns, kUsual, quiet()).cause == Cause::kMachine);
  }
  SECTION("an interrupt of a device on its core") {
    auto change = quiet();
    change.interrupts->devices = 3;
    const auto a = attribute(t, kPeriod_ns, kUsual, change);
    CHECK(a.cause == Cause::kInterrupt);
    CHECK_THAT(a.evidence, Contains("3 device and 0 kernel interrupts in the 20 ms around it"));
  }
  SECTION("what a host took outweighs interrupts") {
    auto change = quiet();
    change.interrupts->devices = 3;
    change.stolen_ms = 10;
    const auto a = attribute(t, kPeriod_ns, kUsual, change);
    CHECK(a.cause == Cause::kMachine);
    CHECK_THAT(a.evidence, Contains("its host took 10 ms"));
  }
  SECTION("what the kernel measured decides, and is named, longest first") {
    auto change = quiet();
    const Noise timer{
        .kind = Noise::Kind::kInterrupt, .name = "local_timer", .number = 236, .from_ns = 0, .duration_ns = 8'000};
    const Noise worker{
        .kind = Noise::Kind::kThread, .name = "kworker/3:1", .number = 77, .from_ns = 0, .duration_ns = 1'400'000};
    const Noise card{
        .kind = Noise::Kind::kInterrupt, .name = "eth0", .number = 24, .from_ns = 0, .duration_ns = 1'450'000};
    change.noise = {timer, worker};
    const auto switched = attribute(t, kPeriod_ns, kUsual, change);
    CHECK(switched.cause == Cause::kContextSwitch);
    CHECK_THAT(switched.evidence, Contains("the kernel measured kworker/3:1 1400 us, local_timer 8 us"));
    change.noise = {timer, card};
    CHECK(attribute(t, kPeriod_ns, kUsual, change).cause == Cause::kInterrupt);
  }
  SECTION("what the kernel measures and did not see is the machine, also with interrupts counted around it") {
    auto change = quiet();
    change.interrupts->devices = 3;
    change.noise = std::vector<Noise>{{Noise::Kind::kInterrupt, "local_timer", 236, 0, 8'000}};
    CHECK(attribute(t, kPeriod_ns, kUsual, change).cause == Cause::kMachine);
    change.noise->clear();
    CHECK_THAT(attribute(t, kPeriod_ns, kUsual, change).evidence, Contains("the kernel measured nothing on its core"));
  }
  SECTION("none of them is the machine, with what that is inferred from") {
    const auto a = attribute(t, kPeriod_ns, kUsual, std::nullopt);
    CHECK(a.cause == Cause::kMachine);
    CHECK_THAT(a.evidence, Contains("took 1715 us, 215 of them on its core") &&
                               Contains("no fault, no context switch") &&
                               Contains("the bare timer woke up to 30 us late"));
  }
}

TEST_CASE("a late tick that met its deadline has the cause of the part that grew most") {
  CHECK(attribute(woken_late(1, 200'000), kPeriod_ns, kUsual, quiet()).cause == Cause::kLateWake);
  auto work = delayed_in_solve(1, 200'000);
  work.cpu_ns += 200'000;
  work.predicted_ns = 390'000;
  CHECK(attribute(work, kPeriod_ns, kUsual, quiet()).cause ==
        Cause::kComputing);  // kOwnWork is reported for overruns only
  // On its core all the time, as it seems; but 2 x 90 us are the most that its counts explain.
  auto unexplained = delayed_in_solve(1, 500'000);
  unexplained.cpu_ns += 500'000;
  unexplained.predicted_ns = 90'000;
  CHECK(attribute(unexplained, kPeriod_ns, kUsual, quiet()).cause == Cause::kMachine);
}
