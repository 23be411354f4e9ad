#include "rt/loop/tick_probe.h"

#include <sys/resource.h>
#include <unistd.h>

#include <span>

#include "rt/base/clock.h"

namespace tactus::loop {

WindowKind WindowPlan::at(std::uint64_t deadline) const noexcept {
  const std::uint64_t round = loop + bare + rest, place = round > 0 ? deadline % round : 0;
  if (place < loop || round == 0) return WindowKind::kLoop;
  return place < loop + bare ? WindowKind::kBare : WindowKind::kRest;
}

std::uint64_t WindowPlan::into(std::uint64_t deadline) const noexcept {
  const std::uint64_t round = loop + bare + rest, place = round > 0 ? deadline % round : deadline;
  switch (at(deadline)) {
    case WindowKind::kLoop:
      return bare + rest == 0 ? deadline : place;
    case WindowKind::kBare:
      return place - loop;
    case WindowKind::kRest:
      return place - loop - bare;
  }
  return place;
}

std::uint64_t WindowPlan::left(std::uint64_t deadline) const noexcept {
  const std::uint64_t lengths[]{loop, bare, rest};
  const std::uint64_t length = lengths[static_cast<std::size_t>(at(deadline))], past = into(deadline);
  return length > past ? length - past : 0;
}

TickProbe::Usage TickProbe::Usage::now() noexcept {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return {.minor_faults = static_cast<std::uint32_t>(usage.ru_minflt),
          .major_faults = static_cast<std::uint32_t>(usage.ru_majflt),
          .voluntary = static_cast<std::uint32_t>(usage.ru_nvcsw),
          .involuntary = static_cast<std::uint32_t>(usage.ru_nivcsw)};
}

void TickProbe::start_record(const TickTiming& timing) noexcept {
  times_ = {};
  times_.skipped = timing.skipped;
  times_.scheduled_ns = timing.scheduled_ns;
  times_.woke_ns = timing.woke_ns;
  times_.into_window = static_cast<std::uint32_t>(plan_.into(timing.deadline));
}

void TickProbe::finish_record(std::uint32_t kind) noexcept {
  const Usage now = Usage::now();
  times_.minor_faults = now.minor_faults - usage_.minor_faults;
  times_.major_faults = now.major_faults - usage_.major_faults;
  times_.voluntary_switches = now.voluntary - usage_.voluntary;
  times_.involuntary_switches = now.involuntary - usage_.involuntary;
  usage_ = now;
  (void)ring_.try_push(kind, std::span<const TickTimes, 1>(&times_, 1));  // the ring counts what it drops
}

void TickProbe::bare(const TickTiming& timing) noexcept {
  start_record(timing);
  times_.tick = bare_ticks_++;
  times_.read_ns = times_.adopted_ns = times_.coupled_ns = times_.collided_ns = times_.stepped_ns = times_.computed_ns =
      times_.wrote_ns = timing.woke_ns;
  finish_record(kBareTimes);
}

void TickProbe::rest(const TickTiming& timing, std::int64_t period_ns) noexcept {
  const std::uint64_t left = plan_.left(timing.deadline);
  const std::int64_t until_ns = timing.scheduled_ns + static_cast<std::int64_t>(left > 0 ? left - 1 : 0) * period_ns;
  resting_until_ns_.store(until_ns, std::memory_order_relaxed);
  MonotonicClock::sleep_until_ns(until_ns);
  resting_until_ns_.store(0, std::memory_order_relaxed);
}

void TickProbe::begin(const TickTiming& timing) noexcept {
  if (loop_ticks_ == 0) thread_id_.store(gettid(), std::memory_order_relaxed);
  start_record(timing);
  times_.tick = loop_ticks_++;
  cpu_began_ns_ = MonotonicClock::thread_cpu_ns();
}

void TickProbe::stage_done(void* self, TickStage stage) noexcept {
  TickTimes& times = static_cast<TickProbe*>(self)->times_;
  const std::int64_t now_ns = MonotonicClock::now_ns();
  switch (stage) {
    case TickStage::kAdopt:
      times.adopted_ns = now_ns;
      break;
    case TickStage::kCouple:
      times.coupled_ns = now_ns;
      break;
    case TickStage::kStep:
      times.stepped_ns = now_ns;
      if (times.collided_ns == 0) times.collided_ns = now_ns;  // nothing was solved
      break;
  }
}

void TickProbe::end(std::int64_t computed_ns, std::int64_t wrote_ns) noexcept {
  times_.computed_ns = computed_ns;
  times_.wrote_ns = wrote_ns;
  times_.cpu_ns = MonotonicClock::thread_cpu_ns() - cpu_began_ns_;
  finish_record(kLoopTimes);
}

}  // namespace tactus::loop
