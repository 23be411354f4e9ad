// What the kernel's texts say about a core: recorded texts, and two looks made into a change.
#include "tools/timing/machine_watch.h"

#include <catch2/catch.hpp>

#include "tools/timing/cyclictest.h"

using namespace tactus;
using namespace tactus::timing;

namespace {

// cpu 1 is offline: the columns are those of 0, 2 and 3.
const char* const kInterrupts =
    "            CPU0       CPU2       CPU3       \n"
    "   1:          9          0          2   IO-APIC    1-edge      i8042\n"
    "  24:          0         50        400   PCI-MSI 65536-edge      nvme0q0\n"
    " LOC:      90000      80000      70000   Local timer interrupts\n"
    " RES:         10         20         30   Rescheduling interrupts\n"
    " TLB:          1          2          3   TLB shootdowns\n"
    " ERR:          0\n";

}  // namespace

TEST_CASE("a core's interrupts are told apart by kind, in the column of that core") {
  const auto three = parse_interrupts(kInterrupts, 3);
  REQUIRE(three.has_value());
  CHECK(three->timer == 70000);
  CHECK(three->devices == 402);
  CHECK(three->kernel == 33);
  CHECK(parse_interrupts(kInterrupts, 2)->devices == 50);
  CHECK_FALSE(parse_interrupts(kInterrupts, 1).has_value());
  CHECK_FALSE(parse_interrupts("", 0).has_value());
}

TEST_CASE("how long a thread waited for its core is the second figure of its schedstat") {
  CHECK(parse_wait_ns("168542300 4711 932\n") == 4711u);
  CHECK_FALSE(parse_wait_ns("").has_value());
}

TEST_CASE("what happened around a time is the change from the last look before it to the first one after") {
  MachineHistory history;
  for (std::uint64_t i = 0; i < 5; ++i)
    history.add({static_cast<std::int64_t>(i) * 20, InterruptCounts{i, 10 * i, 0}, i * i, std::nullopt});
  const auto change = history.around(25, 45);
  REQUIRE(change.has_value());
  CHECK(change->span_ns == 40);                // from 20 to 60
  CHECK(change->interrupts->devices == 20);    // 30 - 10
  CHECK(change->stolen_ms == 8u);              // 9 - 1
  CHECK_FALSE(change->waited_ns.has_value());  // nobody told
  CHECK_FALSE(history.around(70, 90).has_value());
}

TEST_CASE("the kernel's measurement is cut to the requested time") {
  MachineHistory history;
  const auto noise = [](std::int64_t from, std::int64_t duration) {
    return Noise{.kind = Noise::Kind::kInterrupt,
                 .name = "local_timer",
                 .number = 236,
                 .from_ns = from,
                 .duration_ns = duration};
  };
  history.add({0, {}, {}, {}, std::vector<Noise>{noise(-5, 3)}});
  history.add(
      {100, {}, {}, {}, std::vector<Noise>{noise(10, 5), noise(28, 4), noise(40, 2), noise(48, 20), noise(60, 5)}});
  const auto change = history.around(30, 50);
  REQUIRE((change && change->noise));
  REQUIRE(change->noise->size() == 3);
  CHECK(change->noise->at(0).duration_ns == 2);  // 28 to 32, from 30 on
  CHECK(change->noise->at(1).duration_ns == 2);
  CHECK(change->noise->at(2).duration_ns == 2);  // 48 to 68, until 50
  history.add({200, {}, {}, {}});
  CHECK_FALSE(history.around(110, 120)->noise.has_value());
}

TEST_CASE("the kernel's osnoise events are read with name, number, end and length") {
  const auto timer = parse_noise(
      "          <idle>-0       [002] d.h1.   124.880123: irq_noise: local_timer:236 start 97.110823711 duration 9432 "
      "ns");
  REQUIRE(timer);
  CHECK(timer->kind == Noise::Kind::kInterrupt);
  CHECK(timer->name == "local_timer");
  CHECK(timer->number == 236);
  CHECK(timer->duration_ns == 9'432);
  CHECK(timer->from_ns ==
        124'880'123'000 - 9'432);  // the line's time is that of its end; its own start, another clock's
  const auto thread = parse_noise(
      "     kworker/2:1-77      [002] d..3.     7.000001: thread_noise: kworker/2:1:77 start 6.999000000 duration 1001 "
      "ns");
  REQUIRE(thread);
  CHECK(thread->kind == Noise::Kind::kThread);
  CHECK(thread->name == "kworker/2:1");
  CHECK(thread->number == 77);
  const auto soft =
      parse_noise("   ksoftirqd-20  [002] ..s1.   1.000100: softirq_noise:    SCHED:7 start 1.0 duration 500 ns");
  REQUIRE(soft);
  CHECK(soft->name == "SCHED");
  const auto nmi = parse_noise("   <...>-20  [002] ..s1.   1.000100: nmi_noise: start 1.000099000 duration 700 ns");
  REQUIRE(nmi);
  CHECK(nmi->name == "nmi");
  CHECK_FALSE(parse_noise("# tracer: timerlat"));
  CHECK_FALSE(parse_noise("   <...>-20  [002] .....   1.0: irq_noise: local_timer:236 start"));
  CHECK_FALSE(parse_noise("   <idle>-0  [002] d.h1.  54.029: #1 context    irq timer_latency       932 ns"));
}

TEST_CASE("a kernel without the tracer gives one line that names what is needed") {
  const auto noise = OsNoise::start(0, "/nonexistent");
  REQUIRE_FALSE(noise.ok());
  CHECK_THAT(noise.message(), Catch::Matchers::Contains("CONFIG_TIMERLAT_TRACER"));
}

TEST_CASE("cyclictest's lines are read one by one, and the first ones not counted") {
  Histogram wake;
  CHECK(add_cyclictest_line("       0:       2:   21690\n", 2, wake));
  CHECK(add_cyclictest_line("       0:       1:  990000\n", 2, wake));
  CHECK_FALSE(add_cyclictest_line("# /dev/cpu_dma_latency set to 0us\n", 2, wake));
  CHECK_FALSE(add_cyclictest_line("Thread 0 Interval: 1500\n", 2, wake));
  CHECK(wake.count() == 1);
  CHECK(wake.max_ns() == 21690);
}

TEST_CASE("cyclictest runs on the loop's core, at its priority and period") {
  const std::string command =
      cyclictest_command({.cpu = 3, .main_cpu = 1, .priority = 70, .period_us = 500, .seconds = 9});
  CHECK(command.find(" -a3 -p70 -i500 -D9 --mainaffinity=1") != std::string::npos);
}
