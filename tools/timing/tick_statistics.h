// Statistics of the ticks of a timing run: times by stage, overruns by cause, the latest ticks with those around them.
//
// Input: records of the probe and samples of the machine, in order of time; a tick is judged after the first sample
// that follows it. Depends on its input alone, so recorded or synthetic figures give the same statistics. Thread: one,
// normal.
// Bound: kWorst spikes, kAround ticks on either side of each, the last kRecent ticks.
#pragma once

#include <array>
#include <deque>
#include <vector>

#include "rt/base/histogram.h"
#include "tools/timing/cause.h"

namespace tactus::timing {

enum class TimedStage : std::uint32_t { kWake, kRead, kAdopt, kCouple, kCollide, kSolve, kWrite };
inline constexpr std::uint32_t kStages = 7;
const char* name_of(TimedStage stage);
// Duration from the end of the previous stage, or from the deadline.
std::int64_t duration_ns(const loop::TickTimes& tick, TimedStage stage);

struct Spike {
  loop::TickTimes times;
  Attribution attribution;
  bool judged{false};
  std::vector<loop::TickTimes> around;  // including itself
};

struct Settings {
  std::int64_t period_ns{1'000'000};
  std::uint64_t warm_up_ticks{1000};  // at the start of the run: not counted
  std::uint32_t settle_ticks{10};     // at the start of each window that follows another: not counted
};

class TickStatistics {
 public:
  static constexpr std::size_t kWorst = 10, kAround = 16, kRecent = 1000;

  explicit TickStatistics(const Settings& settings) : settings_(settings) {}

  void add_loop(const loop::TickTimes& tick);
  void add_bare(const loop::TickTimes& tick);
  void add_look(const MachineLook& look);
  // Judges the remaining ticks with the data available.
  void finish();

  const Settings& settings() const { return settings_; }
  bool late(const loop::TickTimes& tick) const { return tick.wrote_ns > tick.scheduled_ns + settings_.period_ns; }
  Typical typical() const;

  std::array<Histogram, kStages> stages;
  Histogram execution;   // woke to wrote
  Histogram done;        // scheduled to wrote: compared with the deadline
  Histogram overhead;    // execution without the device, collision and solving: the loop's own cost
  Histogram compute;     // read to computed: predicted by the cost model
  Histogram force_age;   // of a force when it is written, since the sample from which it was computed
  Histogram oldest_age;  // of a force when the next one replaces it
  Histogram bare_wake;
  std::uint64_t ticks{0}, bare_ticks{0}, warm_up{0}, skipped{0};
  std::uint64_t minor_faults{0}, major_faults{0}, involuntary_switches{0};
  std::uint64_t overruns{0};
  std::array<std::uint64_t, kCauses> overruns_by_cause{};
  std::uint32_t members_max{0}, contacts_max{0}, points_max{0}, border_max{0};
  std::uint64_t at_capacity{0};  // ticks with the largest number of members of the run
  std::vector<Spike> spikes;     // the latest first
  std::deque<loop::TickTimes> recent;

 private:
  void note_spike(const loop::TickTimes& tick);
  void judge_until(std::int64_t known_ns);

  Settings settings_;
  MachineHistory machine_;
  std::deque<loop::TickTimes> waiting_;  // overruns not judged yet
  loop::TickTimes last_;
  bool has_last_{false};
};

}  // namespace tactus::timing
