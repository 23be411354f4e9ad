#include "rt/thread/periodic_thread.h"

#include <pthread.h>
#include <signal.h>
#include <sys/mman.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <random>
#include <thread>
#include <vector>

#include "tests/support/rt_guard.h"

using namespace tactus;
using namespace tactus::loop;

namespace {

constexpr std::int64_t kPeriod = 1000;

// Time that passes only when told to: sleeping ends exactly at its end plus the next lateness.
struct FakeClock {
  std::int64_t now{0}, cpu{0}, lateness{0};
  std::vector<std::int64_t> slept_until;

  std::int64_t now_ns() const noexcept { return now; }
  std::int64_t thread_cpu_ns() const noexcept { return cpu; }
  void sleep_until_ns(std::int64_t time_ns) noexcept {
    slept_until.push_back(time_ns);
    now = std::max(now, time_ns) + lateness;
    lateness = 0;
  }
  void work(std::int64_t time_ns) noexcept {
    now += time_ns;
    cpu += time_ns;
  }
  void be_pushed_aside(std::int64_t time_ns) noexcept { now += time_ns; }
};
static_assert(Clock<FakeClock>);

// Runs a loop of `count` ticks on the fake clock; `work(i)` is the body of the i-th.
template <class Work>
struct Run {
  FakeClock clock;
  TimingHealth health;
  std::vector<TickTiming> ticks;

  Run(std::size_t count, std::int64_t first_ns, Work work) {
    auto tick = [&](const TickTiming& timing) noexcept {
      ticks.push_back(timing);
      work(clock, ticks.size() - 1);
      return ticks.size() < count;
    };
    const std::atomic<bool> stop{false};
    clock.now = first_ns - 10;
    run_periodic(clock, {kPeriod, kPeriod / 10}, first_ns, tick, stop, health);
  }
};

}  // namespace

TEST_CASE("ticks come at absolute deadlines: lateness and work never shift the later ones", "[loop]") {
  std::mt19937 random(1);
  Run run(1000, 7'000, [&](FakeClock& clock, std::size_t) {
    clock.work(random() % 400);
    clock.lateness = random() % 500;  // of the next wake-up: together always below a period
  });
  REQUIRE(run.ticks.size() == 1000);
  for (std::size_t i = 0; i < run.ticks.size(); ++i) {
    const TickTiming& timing = run.ticks[i];
    REQUIRE(timing.tick == i);
    REQUIRE(timing.deadline == i);
    REQUIRE(timing.scheduled_ns == 7'000 + static_cast<std::int64_t>(i) * kPeriod);
    REQUIRE(timing.woke_ns >= timing.scheduled_ns);
    REQUIRE(timing.skipped == 0);
    REQUIRE(run.clock.slept_until[i] == timing.scheduled_ns);
  }
  CHECK(run.health.ticks == 1000);
  CHECK(run.health.overruns == 0);
  CHECK(run.health.skipped_ticks == 0);
  CHECK(run.health.wake_latency.count() == 1000);
  CHECK(run.health.execution.count() == 1000);
}

TEST_CASE("an overrun is counted once, however many deadlines it passes, and these are skipped, not caught up",
          "[loop]") {
  for (const std::int64_t length : {1001, 1999, 2000, 2001, 5500, 1'000'000}) {
    INFO("a tick of " << length << " ns, the period is " << kPeriod);
    Run run(4, 0, [&](FakeClock& clock, std::size_t i) { clock.work(i == 1 ? length : 10); });
    // The first deadline that is not before the end of the long tick, which began at deadline 1.
    const auto next = static_cast<std::uint64_t>(1 + (length + kPeriod - 1) / kPeriod);
    CHECK(run.health.overruns == 1);
    CHECK(run.health.skipped_ticks == next - 2);
    REQUIRE(run.ticks.size() == 4);
    CHECK(run.ticks[2].deadline == next);
    CHECK(run.ticks[2].skipped == next - 2);
    CHECK(run.ticks[2].tick == 2);
    CHECK(run.ticks[2].last_execution_ns == length);
    CHECK(run.ticks[3].deadline == next + 1);
    CHECK(run.ticks[3].skipped == 0);
    CHECK(run.ticks[2].woke_ns == static_cast<std::int64_t>(next) * kPeriod);
  }
}

TEST_CASE("a tick that ends exactly at the next deadline is no overrun", "[loop]") {
  Run run(3, 0, [](FakeClock& clock, std::size_t) { clock.work(kPeriod); });
  CHECK(run.health.overruns == 0);
  CHECK(run.health.skipped_ticks == 0);
  CHECK(run.ticks[2].deadline == 2);
}

TEST_CASE("two ticks never begin in one period, whatever happens", "[loop]") {
  std::mt19937 random(2);
  Run run(5000, 3'000, [&](FakeClock& clock, std::size_t) {
    switch (random() % 8) {
      case 0:
        clock.work(random() % 10'000);
        break;
      case 1:
        clock.be_pushed_aside(random() % 10'000);
        break;
      case 2:
        clock.lateness = random() % 5'000;
        break;
      default:
        clock.work(random() % 900);
    }
  });
  std::uint64_t skipped = 0;
  for (std::size_t i = 1; i < run.ticks.size(); ++i) {
    const TickTiming &a = run.ticks[i - 1], &b = run.ticks[i];
    REQUIRE(b.deadline > a.deadline);
    REQUIRE(b.skipped == b.deadline - a.deadline - 1);
    REQUIRE(b.scheduled_ns == 3'000 + static_cast<std::int64_t>(b.deadline) * kPeriod);
    REQUIRE(b.scheduled_ns >= a.woke_ns + b.last_execution_ns);  // a period of its own: no burst
    skipped += b.skipped;
  }
  CHECK(skipped > 0);
  CHECK(run.health.skipped_ticks >= skipped);
  CHECK(run.health.ticks == 5000);
}

TEST_CASE("an overrun is counted whatever caused it: preemption, a late wake-up or work of its own", "[loop]") {
  Run aside(4, 0, [](FakeClock& clock, std::size_t i) {
    clock.work(300);
    if (i == 1) clock.be_pushed_aside(3 * kPeriod);
  });
  CHECK(aside.health.overruns == 1);

  Run late(4, 0, [](FakeClock& clock, std::size_t i) {
    clock.work(300);
    if (i == 1) clock.lateness = kPeriod - 100;
  });
  CHECK(late.health.overruns == 1);
  CHECK(late.health.late_wakes == 1);
  CHECK(late.health.wake_latency.max_ns() == kPeriod - 100);

  Run work(4, 0, [](FakeClock& clock, std::size_t i) { clock.work(i == 1 ? kPeriod + 1 : 300); });
  CHECK(work.health.overruns == 1);
}

TEST_CASE("a wake-up is late beyond the limit, not at it", "[loop]") {
  Run run(3, 0, [](FakeClock& clock, std::size_t i) { clock.lateness = i == 0 ? kPeriod / 10 : kPeriod / 10 + 1; });
  CHECK(run.health.late_wakes == 1);
}

TEST_CASE("the tick receives the health counters up to the tick before", "[loop]") {
  std::vector<std::uint64_t> seen;
  FakeClock clock;
  TimingHealth health;
  auto tick = [&](const TickTiming& timing) noexcept {
    seen.push_back(timing.health->ticks);
    return seen.size() < 3;
  };
  const std::atomic<bool> stop{false};
  run_periodic(clock, {kPeriod, kPeriod}, 0, tick, stop, health);
  CHECK(seen == std::vector<std::uint64_t>{0, 1, 2});
}

TEST_CASE("a stop takes effect before the next tick", "[loop]") {
  FakeClock clock;
  TimingHealth health;
  std::atomic<bool> stop{false};
  auto tick = [&](const TickTiming& timing) noexcept {
    if (timing.tick == 4) stop = true;
    return true;
  };
  run_periodic(clock, {kPeriod, kPeriod}, 0, tick, stop, health);
  CHECK(health.ticks == 5);
}

TEST_CASE("the loop itself allocates and locks nothing", "[loop]") {
  struct QuietClock {
    std::int64_t now{0};
    std::int64_t now_ns() const noexcept { return now; }
    std::int64_t thread_cpu_ns() const noexcept { return 0; }
    void sleep_until_ns(std::int64_t time_ns) noexcept { now = std::max(now, time_ns); }
  } clock;
  TimingHealth health;
  const std::atomic<bool> stop{false};
  auto tick = [&](const TickTiming& timing) noexcept {
    clock.now += timing.tick % 7 * 300;
    return timing.tick < 1000;
  };
  const test::RtGuard guard;
  run_periodic(clock, {kPeriod, kPeriod}, 0, tick, stop, health);
  const auto allocations = guard.allocations(), locks = guard.locks();
  CHECK(allocations == 0);
  CHECK(locks == 0);
  CHECK(health.overruns > 0);
}

TEST_CASE("loops start at a full period of the clock, after now", "[loop]") {
  for (const std::int64_t now : {0, 1, 999, 1000, 1001, 123'456'789}) {
    const std::int64_t first = next_full_period_ns(now, kPeriod);
    CHECK(first % kPeriod == 0);
    CHECK(first > now);
    CHECK(first <= now + kPeriod);
  }
}

// --- the real thread: what must hold whatever the machine does; no time is measured

namespace {

PeriodicSettings gentle() {
  PeriodicSettings settings;
  settings.period = std::chrono::milliseconds(1);
  settings.setup.priority = 0;
  settings.setup.lock_memory = false;
  settings.setup.hold_cpu_awake = false;
  return settings;
}

}  // namespace

TEST_CASE("the thread sets itself up, ticks on its own stack with signals blocked, and ends when the tick says",
          "[loop][threads]") {
  const std::thread::id here = std::this_thread::get_id();
  std::atomic<int> wrong{0};
  std::atomic<std::uint64_t> last_deadline{0};
  auto tick = [&](const TickTiming& timing) noexcept {
    sigset_t blocked;
    pthread_sigmask(SIG_SETMASK, nullptr, &blocked);
    if (sigismember(&blocked, SIGINT) != 1 || sigismember(&blocked, SIGTERM) != 1) ++wrong;
    if (std::this_thread::get_id() == here) ++wrong;
    if (!denormals_flushed()) ++wrong;
    if (timing.scheduled_ns % 1'000'000 != 0 || timing.woke_ns < timing.scheduled_ns) ++wrong;
    if (timing.tick > 0 && timing.deadline <= last_deadline) ++wrong;
    last_deadline = timing.deadline;
    return timing.tick + 1 < 20;
  };
  PeriodicThread thread(tick);
  CHECK(!thread.running());
  REQUIRE(thread.start(gentle()).ok());
  CHECK(thread.setup_report().find("denormals")->ok);
  CHECK(thread.setup_report().degraded());
  while (thread.running()) std::this_thread::yield();
  thread.stop();
  CHECK(wrong == 0);
  CHECK(thread.health().ticks == 20);
  CHECK(thread.health().wake_latency.count() == 20);
  CHECK(thread.health().skipped_ticks >= last_deadline + 1 - 20);
  sigset_t blocked;
  pthread_sigmask(SIG_SETMASK, nullptr, &blocked);
  CHECK(sigismember(&blocked, SIGINT) == 0);
}

TEST_CASE("stop ends the loop and may be followed by a new start with new counters", "[loop][threads]") {
  std::atomic<std::uint64_t> ticks{0};
  auto tick = [&](const TickTiming&) noexcept {
    ++ticks;
    return true;
  };
  PeriodicThread thread(tick);
  for (int round = 0; round < 3; ++round) {
    ticks = 0;
    REQUIRE(thread.start(gentle()).ok());
    CHECK(!thread.start(gentle()).ok());
    CHECK(thread.running());
    while (ticks < 3) std::this_thread::yield();
    thread.stop();
    CHECK(!thread.running());
    CHECK(thread.health().ticks == ticks);
    CHECK(thread.health().wake_latency.count() == ticks);
  }
}

TEST_CASE("faults that the tick causes are in the health counters", "[loop][threads]") {
  constexpr std::size_t kPages = 50;
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  void* mapping = mmap(nullptr, kPages * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  REQUIRE(mapping != MAP_FAILED);
  madvise(mapping, kPages * page, MADV_NOHUGEPAGE);
  auto* bytes = static_cast<volatile char*>(mapping);
  auto tick = [&](const TickTiming& timing) noexcept {
    bytes[timing.tick * page] = 1;
    return timing.tick + 1 < kPages;
  };
  PeriodicThread thread(tick);
  REQUIRE(thread.start(gentle()).ok());
  while (thread.running()) std::this_thread::yield();
  thread.stop();
  munmap(mapping, kPages * page);
  CHECK(thread.health().minor_faults + thread.health().major_faults >= 1);
}

TEST_CASE("a period of nothing is refused", "[loop]") {
  auto tick = [](const TickTiming&) noexcept { return false; };
  PeriodicThread thread(tick);
  PeriodicSettings settings = gentle();
  settings.period = std::chrono::nanoseconds(0);
  CHECK(!thread.start(settings).ok());
  CHECK(!thread.running());
}
