// Measures the time of each stage of a tick, and the page faults and context switches of the thread. One record per
// tick goes through a ring to a normal thread, which evaluates them.
//
// Besides ticks of the loop there are windows in which the thread wakes at the same period and does nothing, so that
// the bare timer is measured by the same thread on the same core in the same minute, and windows in which it sleeps, so
// that another program can use the core. Windows are counted in deadlines and alternate: loop, bare, rest.
// Thread: construction [setup]; window(), begin() to end(), bare(), rest() [rt]; ring() consumer and resting(): a
// normal thread. Units: ns of CLOCK_MONOTONIC. Bound: a record that does not fit the ring is dropped and counted there.
// Cost: one clock reading per stage and one getrusage per tick, about 1 us; not a part of `tactus run`.
#pragma once

#include <atomic>
#include <cstdint>
#include <type_traits>

#include "rt/base/ring.h"
#include "rt/loop/tick_stages.h"
#include "rt/thread/timing.h"

namespace tactus::loop {

enum class WindowKind : std::uint32_t { kLoop = 0, kBare = 1, kRest = 2 };

// Lengths of the windows, in deadlines; 0: no window of that kind.
struct WindowPlan {
  std::uint64_t loop{1}, bare{0}, rest{0};

  WindowKind at(std::uint64_t deadline) const noexcept;
  // Deadlines from this one to the end of its window.
  std::uint64_t left(std::uint64_t deadline) const noexcept;
  std::uint64_t into(std::uint64_t deadline) const noexcept;  // deadlines since the window began
};

// Each time is the end of a stage. A stage that did not take place has the time of the stage before it.
struct TickTimes {
  std::uint64_t tick{0};  // number of the loop's tick, or of the bare timer's
  std::uint64_t skipped{0};
  std::int64_t scheduled_ns{0}, woke_ns{0}, read_ns{0}, adopted_ns{0}, coupled_ns{0}, collided_ns{0}, stepped_ns{0},
      computed_ns{0}, wrote_ns{0};
  std::int64_t cpu_ns{0};        // processor time of the thread, from woke to wrote
  std::int64_t predicted_ns{0};  // by the cost model, for read to computed
  // Since the end of the tick before.
  std::uint32_t minor_faults{0}, major_faults{0}, voluntary_switches{0}, involuntary_switches{0};
  std::uint32_t members{0}, contacts{0}, points{0}, border{0}, sub_steps{0};
  std::uint32_t into_window{0};  // deadlines since its window began
};
static_assert(std::is_trivially_copyable_v<TickTimes>);

inline constexpr std::uint32_t kLoopTimes = 1, kBareTimes = 2;  // kinds of record in the ring

class TickProbe {
 public:
  explicit TickProbe(const WindowPlan& plan) : plan_(plan), ring_(kRingBytes) {}

  WindowKind window(const TickTiming& timing) const noexcept { return plan_.at(timing.deadline); }
  void bare(const TickTiming& timing) noexcept;
  // Sleeps to the last deadline of the window.
  void rest(const TickTiming& timing, std::int64_t period_ns) noexcept;

  void begin(const TickTiming& timing) noexcept;
  void read_done(std::int64_t now_ns) noexcept { times_.read_ns = now_ns; }
  // Called by the cut predicate: its first call in a tick ends the collision stage.
  void sweep_begins(std::int64_t now_ns) noexcept {
    if (times_.collided_ns == 0) times_.collided_ns = now_ns;
  }
  StageObserver stages() noexcept { return {&TickProbe::stage_done, this}; }
  // The record of this tick; the caller fills in its counts.
  TickTimes& times() noexcept { return times_; }
  void end(std::int64_t computed_ns, std::int64_t wrote_ns) noexcept;

  Ring& ring() noexcept { return ring_; }
  // Kernel thread id of the measured thread; 0 before its first tick.
  int thread_id() const noexcept { return thread_id_.load(std::memory_order_relaxed); }
  // End of the rest in progress; 0: none.
  std::int64_t resting_until_ns() const noexcept { return resting_until_ns_.load(std::memory_order_relaxed); }

 private:
  static constexpr std::uint64_t kRingBytes = 4u << 20;  // 20 s of 1 kHz

  struct Usage {
    std::uint32_t minor_faults{0}, major_faults{0}, voluntary{0}, involuntary{0};
    static Usage now() noexcept;
  };

  static void stage_done(void* self, TickStage stage) noexcept;
  void start_record(const TickTiming& timing) noexcept;
  void finish_record(std::uint32_t kind) noexcept;

  WindowPlan plan_;
  Ring ring_;
  TickTimes times_;
  Usage usage_;
  std::int64_t cpu_began_ns_{0};
  std::uint64_t bare_ticks_{0}, loop_ticks_{0};
  std::atomic<std::int64_t> resting_until_ns_{0};
  std::atomic<int> thread_id_{0};
};

}  // namespace tactus::loop
