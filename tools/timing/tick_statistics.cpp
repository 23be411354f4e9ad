#include "tools/timing/tick_statistics.h"

#include <algorithm>

namespace tactus::timing {
namespace {

std::int64_t lateness_ns(const loop::TickTimes& tick) { return tick.wrote_ns - tick.scheduled_ns; }

}  // namespace

const char* name_of(TimedStage stage) {
  constexpr std::array<const char*, kStages> names{"wake", "read", "adopt", "couple", "collide", "solve", "write"};
  return names[static_cast<std::size_t>(stage)];
}

std::int64_t duration_ns(const loop::TickTimes& t, TimedStage stage) {
  switch (stage) {
    case TimedStage::kWake:
      return t.woke_ns - t.scheduled_ns;
    case TimedStage::kRead:
      return t.read_ns - t.woke_ns;
    case TimedStage::kAdopt:
      return t.adopted_ns - t.read_ns;
    case TimedStage::kCouple:
      return t.coupled_ns - t.adopted_ns;
    case TimedStage::kCollide:
      return t.collided_ns - t.coupled_ns;
    case TimedStage::kSolve:
      return t.stepped_ns - t.collided_ns;
    case TimedStage::kWrite:
      return t.wrote_ns - t.stepped_ns;
  }
  return 0;
}

Typical TickStatistics::typical() const {
  return {static_cast<std::int64_t>(stages[0].percentile_ns(50)),
          static_cast<std::int64_t>(execution.percentile_ns(50)), static_cast<std::int64_t>(bare_wake.max_ns())};
}

void TickStatistics::add_loop(const loop::TickTimes& t) {
  if (warm_up < settings_.warm_up_ticks) {
    ++warm_up;
    return;
  }
  // After another window the caches are cold, which is not typical of a run.
  if (t.into_window < settings_.settle_ticks) {
    has_last_ = false;
    return;
  }
  ++ticks;
  for (std::uint32_t i = 0; i < kStages; ++i) stages[i].record(duration_ns(t, static_cast<TimedStage>(i)));
  execution.record(t.wrote_ns - t.woke_ns);
  done.record(lateness_ns(t));
  compute.record(t.computed_ns - t.read_ns);
  const std::int64_t device_ns = (t.read_ns - t.woke_ns) + (t.wrote_ns - t.computed_ns);
  overhead.record(t.wrote_ns - t.woke_ns - device_ns - (t.stepped_ns - t.coupled_ns));
  force_age.record(t.wrote_ns - t.woke_ns);
  if (has_last_) oldest_age.record(t.wrote_ns - last_.woke_ns);
  last_ = t;
  has_last_ = true;
  skipped += t.skipped;
  minor_faults += t.minor_faults;
  major_faults += t.major_faults;
  involuntary_switches += t.involuntary_switches;
  if (t.members > members_max) at_capacity = 0;
  members_max = std::max(members_max, t.members);
  contacts_max = std::max(contacts_max, t.contacts);
  points_max = std::max(points_max, t.points);
  border_max = std::max(border_max, t.border);
  if (t.members == members_max) ++at_capacity;
  if (late(t)) {
    ++overruns;
    waiting_.push_back(t);
  }
  note_spike(t);
  recent.push_back(t);
  if (recent.size() > kRecent) recent.pop_front();
}

void TickStatistics::add_bare(const loop::TickTimes& t) {
  if (warm_up < settings_.warm_up_ticks || t.into_window < settings_.settle_ticks) return;
  ++bare_ticks;
  bare_wake.record(duration_ns(t, TimedStage::kWake));
}

// The latest kWorst; later ticks are added to a spike as they arrive.
void TickStatistics::note_spike(const loop::TickTimes& t) {
  for (Spike& spike : spikes)
    if (t.tick > spike.times.tick && t.tick <= spike.times.tick + kAround) spike.around.push_back(t);
  if (spikes.size() == kWorst && lateness_ns(t) <= lateness_ns(spikes.back().times)) return;
  Spike spike{.times = t, .attribution = {}, .judged = false, .around = {}};
  const std::size_t before = std::min(recent.size(), kAround);
  spike.around.assign(recent.end() - static_cast<std::ptrdiff_t>(before), recent.end());
  spike.around.push_back(t);
  const auto place = std::upper_bound(spikes.begin(), spikes.end(), t, [](const auto& tick, const Spike& other) {
    return lateness_ns(tick) > lateness_ns(other.times);
  });
  spikes.insert(place, std::move(spike));
  if (spikes.size() > kWorst) spikes.pop_back();
}

void TickStatistics::add_look(const MachineLook& look) {
  machine_.add(look);
  judge_until(look.at_ns);
}

void TickStatistics::finish() { judge_until(INT64_MAX); }

void TickStatistics::judge_until(std::int64_t known_ns) {
  const Typical usual = typical();
  while (!waiting_.empty() && waiting_.front().wrote_ns <= known_ns) {
    const loop::TickTimes& t = waiting_.front();
    const auto cause = attribute(t, settings_.period_ns, usual, machine_.around(t.scheduled_ns, t.wrote_ns)).cause;
    ++overruns_by_cause[static_cast<std::size_t>(cause)];
    waiting_.pop_front();
  }
  for (Spike& spike : spikes) {
    if (spike.judged || spike.times.wrote_ns > known_ns) continue;
    spike.attribution = attribute(spike.times, settings_.period_ns, usual,
                                  machine_.around(spike.times.scheduled_ns, spike.times.wrote_ns));
    spike.judged = true;
  }
}

}  // namespace tactus::timing
