#include "tools/session/running_summary.h"

#include <cstring>

namespace tactus::session {

void RunningSummary::take(std::uint32_t kind, std::span<const std::byte> payload) noexcept {
  loop::TickRecord tick;
  if (kind != loop::kTickRecord || payload.size() != sizeof tick) return;
  std::memcpy(&tick, payload.data(), sizeof tick);
  take(tick);
}

void RunningSummary::take(const loop::TickRecord& tick) noexcept {
  const std::lock_guard lock(mutex_);
  const bool adopts = tick.adopts != 0;
  const std::uint32_t ended = adopts ? cycle_ticks_ : 0;
  if (adopts) cycle_ticks_ = 0;
  ++cycle_ticks_;
  stats_.add(tick.out, tick.sub_steps, 0, ended, start_.ratio);
}

void RunningSummary::take_world(const sim::GlobalStatistics& statistics) noexcept {
  const std::unique_lock lock(world_mutex_, std::try_to_lock);
  if (lock.owns_lock()) world_ = statistics;
}

void RunningSummary::take_setup(const loop::SetupReport& setup) {
  const std::lock_guard lock(mutex_);
  start_.setup = setup;
  start_.real_time = true;
}

RunSummary RunningSummary::so_far() const {
  RunSummary summary;
  {
    const std::lock_guard lock(mutex_);
    summary = start_;
    summary.stats = stats_;
  }
  const std::lock_guard lock(world_mutex_);
  if (!summary.has_global) return summary;
  summary.global = world_;
  summary.overlapped = overlapped_of(scene_, world_.overlap);
  return summary;
}

RunSummary RunningSummary::so_far(const LiveStatus& live) const {
  constexpr auto relaxed = std::memory_order_relaxed;
  RunSummary summary = so_far();
  summary.timing.ticks = live.ticks.load(relaxed);
  summary.timing.skipped_ticks = live.skipped.load(relaxed);
  summary.overruns_late_wake = live.late_wake.load(relaxed);
  summary.overruns_own_work = live.own_work.load(relaxed);
  summary.overruns_interrupted = live.interrupted.load(relaxed);
  return summary;
}

}  // namespace tactus::session
