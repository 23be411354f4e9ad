// The ticks of a run with a watcher in every second window: times with and without it, from windows in turns.
//
// A window counts as watched if the watcher took frames in it, and as unwatched if nobody watched from its beginning to
// its end; one that is neither is counted apart. Thread: one, normal. Bound: two times for each tick of a window.
// Units: ns.
#pragma once

#include <functional>
#include <vector>

#include "rt/base/histogram.h"
#include "rt/base/result.h"
#include "rt/loop/tick_probe.h"
#include "tools/session/realtime_tick.h"
#include "tools/session/session.h"

namespace tactus::timing {

// A viewer that watches in every second window. Its functions are called while the loop rests, except `counts`.
struct WindowWatcher {
  // Before the run: makes it watchable. Returns what the global thread calls after each step.
  std::function<Result<session::RealtimeTaps>(session::Session&)> prepare;
  std::function<Status()> attach;  // returns when it watches
  std::function<void()> detach;    // returns when it has left
  struct Counts {
    std::uint64_t frames{0};    // taken so far
    std::uint32_t watchers{0};  // of the run, now
  };
  std::function<Counts()> counts;

  explicit operator bool() const { return static_cast<bool>(attach); }
};

// Times of the windows of one kind.
struct WindowTimes {
  std::uint64_t windows{0}, ticks{0}, frames{0};
  Histogram wake;       // from the deadline to the thread's running
  Histogram execution;  // a tick's own part: read, compute, write
};

class WatchedWindows {
 public:
  enum class Kind { kUnwatched, kWatched };

  void begin(Kind kind, const WindowWatcher::Counts& counts);
  // A window without ticks, as in the warm-up, is none.
  void end(const WindowWatcher::Counts& counts);
  // Outside of a window: nothing.
  void add(const loop::TickTimes& tick);

  bool any() const { return with.windows + without.windows + other > 0; }

  WindowTimes with, without;
  std::uint64_t other{0};  // windows that were neither

 private:
  struct Times {
    std::int64_t wake_ns, execution_ns;
  };
  bool open_{false};
  Kind kind_{Kind::kUnwatched};
  WindowWatcher::Counts began_;
  std::vector<Times> times_;  // of the window
};

// A percentile of `with` divided by that of `without`; 0 if there is none.
double ratio_of(const Histogram& with, const Histogram& without, double percent);

}  // namespace tactus::timing
