// One timing run: the real loop on the simulated device, its probe, the load on the other cores, and the sampling of
// the machine.
//
// Thread: the main one. A thread of normal priority on the other cores reads the probe's ring and samples the machine
// fifty times a second; the loop itself is that of `tactus run` (tools/session/realtime_run.h).
#pragma once

#include <atomic>
#include <functional>
#include <optional>

#include "tools/session/realtime_run.h"
#include "tools/timing/load.h"
#include "tools/timing/tick_statistics.h"
#include "tools/timing/verdict.h"
#include "tools/timing/watched_windows.h"

namespace tactus::timing {

struct TimingOptions {
  session::RunOptions run;  // its scene may be empty: the worst case for `members` and `sub_steps`
  unsigned members{64}, sub_steps{4}, ratio{10};
  double duration_s{60};  // of all windows together
  double window_s{1};     // of one window of the loop, and of the bare timer after it
  bool bare{true};
  LoadKind load{LoadKind::kNone};
  bool os_noise{false};            // read the kernel's osnoise events
  bool against_cyclictest{false};  // instead of the bare timer, in windows of 10 s
  bool with_viewer{false};         // instead of the bare timer: a watcher in every second window
};

inline constexpr double kAgainstWindow_s = 10;
inline constexpr double kViewerRest_s = 1;  // in which the watcher comes or goes

struct TimingResult {
  TimingOptions options{};
  session::RunSummary summary{};
  TickStatistics statistics;
  std::vector<VerdictRow> rows{};
  Histogram cyclictest_wake{};  // empty without it
  std::uint64_t records_lost{0};
  std::string scene_text{};  // what was run
  WatchedWindows viewer{};   // empty without one

  TimingVerdict verdict() const { return verdict_of(rows); }
};

struct TimingProblem {
  bool input{false};  // true: the user's input is wrong; false: the machine fails
  std::string text;
};

// Called about five times a second with the completed fraction and the state of the loop.
using TimingProgress = std::function<void(double share, const session::LiveStatus& live)>;

// Checks ranges. Error, one line: the option, what was given, what is accepted.
Status check(const TimingOptions& options);

// Empty on an error: see `problem`. `watcher`: of `with_viewer`.
std::optional<TimingResult> run_timing(const TimingOptions& options, const TimingProgress& progress,
                                       const std::atomic<bool>& stop, TimingProblem& problem,
                                       const WindowWatcher& watcher = {});

}  // namespace tactus::timing
