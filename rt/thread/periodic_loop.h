// The schedule of a periodic loop: absolute deadlines, one tick per deadline; deadlines that an overrun missed are
// skipped.
//
// Missed deadlines are never made up for by several ticks at once: a device that received no command for three periods
// gains nothing from three commands at once, and three steps of the physics at once would supply energy to the hand.
// Thread: [rt], the loop's own; blocks in Clock::sleep_until_ns only. Bound: runs until `stop` is set or the tick
// returns false; ends within one period of either.
#pragma once

#include <atomic>
#include <concepts>
#include <cstdint>

#include "rt/base/check.h"
#include "rt/base/clock.h"
#include "rt/thread/timing.h"

namespace tactus::loop {

struct LoopSettings {
  std::int64_t period_ns{1'000'000};
  std::int64_t late_wake_ns{100'000};  // wake-ups later than this are counted
};

// The tick returns false to end the loop.
template <class T>
concept PeriodicTick = requires(T tick, const TickTiming& timing) {
  { tick(timing) }
  noexcept->std::same_as<bool>;
};

// The smallest multiple of the period after `now`: loops of equal period are in phase, independent of when they start.
constexpr std::int64_t next_full_period_ns(std::int64_t now_ns, std::int64_t period_ns) noexcept {
  return (now_ns / period_ns + 1) * period_ns;
}

// The first deadline after `deadline` that is not in the past.
constexpr std::uint64_t next_deadline(std::uint64_t deadline, std::int64_t since_first_ns,
                                      std::int64_t period_ns) noexcept {
  const auto reached = static_cast<std::uint64_t>((since_first_ns + period_ns - 1) / period_ns);
  return reached > deadline + 1 ? reached : deadline + 1;
}

template <Clock C, PeriodicTick Tick>
void run_periodic(C& clock, const LoopSettings& settings, std::int64_t first_ns, Tick& tick,
                  const std::atomic<bool>& stop, TimingHealth& health) noexcept {
  const std::int64_t period_ns = settings.period_ns;
  TACTUS_CHECK(period_ns > 0, period_ns, 0);
  TickTiming timing;
  timing.health = &health;
  for (bool go = true; go;) {
    timing.scheduled_ns = first_ns + static_cast<std::int64_t>(timing.deadline) * period_ns;
    clock.sleep_until_ns(timing.scheduled_ns);
    if (stop.load(std::memory_order_relaxed)) return;  // relaxed: stop() joins, no data depends on the flag
    timing.woke_ns = clock.now_ns();

    go = tick(timing);

    const std::int64_t ended_ns = clock.now_ns();
    const std::int64_t wake_latency_ns = timing.woke_ns - timing.scheduled_ns;
    timing.last_execution_ns = ended_ns - timing.woke_ns;
    health.wake_latency.record(wake_latency_ns);
    health.execution.record(timing.last_execution_ns);
    if (wake_latency_ns > settings.late_wake_ns) ++health.late_wakes;
    if (ended_ns > timing.scheduled_ns + period_ns) ++health.overruns;
    const std::uint64_t next = next_deadline(timing.deadline, ended_ns - first_ns, period_ns);
    timing.skipped = next - timing.deadline - 1;
    health.skipped_ticks += timing.skipped;
    timing.deadline = next;
    health.ticks = ++timing.tick;
  }
}

}  // namespace tactus::loop
