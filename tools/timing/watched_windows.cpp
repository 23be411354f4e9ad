#include "tools/timing/watched_windows.h"

namespace tactus::timing {

void WatchedWindows::begin(Kind kind, const WindowWatcher::Counts& counts) {
  open_ = true;
  kind_ = kind;
  began_ = counts;
  times_.clear();
}

void WatchedWindows::add(const loop::TickTimes& tick) {
  if (open_) times_.push_back({tick.woke_ns - tick.scheduled_ns, tick.wrote_ns - tick.woke_ns});
}

void WatchedWindows::end(const WindowWatcher::Counts& counts) {
  open_ = false;
  if (times_.empty()) return;
  const std::uint64_t frames = counts.frames - began_.frames;
  const bool watched = kind_ == Kind::kWatched && frames > 0 && began_.watchers > 0 && counts.watchers > 0;
  const bool unwatched = kind_ == Kind::kUnwatched && began_.watchers == 0 && counts.watchers == 0;
  if (!watched && !unwatched) {
    ++other;
    return;
  }
  WindowTimes& times = watched ? with : without;
  ++times.windows;
  times.ticks += times_.size();
  times.frames += frames;
  for (const Times& tick : times_) {
    times.wake.record(tick.wake_ns);
    times.execution.record(tick.execution_ns);
  }
}

double ratio_of(const Histogram& with, const Histogram& without, double percent) {
  const auto one = static_cast<double>(with.percentile_ns(percent)),
             other = static_cast<double>(without.percentile_ns(percent));
  return other > 0 ? one / other : 0;
}

}  // namespace tactus::timing
