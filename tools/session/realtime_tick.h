// The body of the haptic thread in real time: one timed tick of the loop (rt/loop/timed_tick.h), what the operator
// asks, the books of the run, and what the screen shows. The proofs run this one.
//
// Thread: construction, end(), the figures [normal], the latter after the thread has ended; operator() [rt].
#pragma once

#include <atomic>
#include <cstdint>

#include "rt/base/histogram.h"
#include "rt/loop/timed_tick.h"
#include "tools/session/arm_gate.h"
#include "tools/session/session.h"

namespace tactus::session {

// The last ticks of a run on a real device: its force fades, then it goes to IDLE and is not left to its watchdog.
inline constexpr double kEnd_s = 2 * loop::kEndFade_s;

// What the screen shows while it runs. Written by the haptic thread, each value by itself.
struct LiveStatus {
  std::atomic<std::uint64_t> ticks{0}, overruns{0}, late_cycles{0}, fault_count{0};
  std::atomic<double> force_N{0};
  std::atomic<std::uint32_t> members{0}, contacts{0}, border{0}, status{0}, fault{0}, resets{0};
  std::atomic<std::uint32_t> device_state{0}, device_fault{0}, device_limits{0};  // what the device says of itself
  std::atomic<std::uint32_t> fault_state{0}, fault_limits{0};                     // when the fault latched
};

// Beside the haptic thread and the global world's: called by them, so functions with their context.
struct RealtimeTaps {
  // [rt] After each tick of the loop, by the haptic thread: no allocation, lock, wait, log or throw.
  void (*ticked)(void* context, const Driver& driver) noexcept {nullptr};
  // After each step, by the global world's thread, which waits for it.
  void (*stepped)(void* context, const sim::GlobalWorld& world) noexcept {nullptr};
  void* context{nullptr};
};

class RealtimeTick {
 public:
  // `probe`: looks into every tick, and may take windows for itself; may be null.
  RealtimeTick(Session& session, LiveStatus& live, std::atomic<std::uint32_t>& requests, std::uint64_t most_ticks,
               ArmGate& gate, loop::TickProbe* probe = nullptr, const RealtimeTaps& taps = {});

  // False: it was the last.
  bool operator()(const loop::TickTiming& timing) noexcept;

  // [normal] The loop ends by itself, after the force has faded and the device has had time to go to IDLE.
  void end() noexcept { ending_.store(true, std::memory_order_relaxed); }
  bool must_end() const noexcept { return real_; }
  // [setup] See TimedTick.
  void cut_at(std::uint32_t sweep) noexcept { tick_.cut_at(sweep); }

  Histogram compute, device;
  loop::ForecastStats forecast;
  std::uint64_t late_wake{0}, own_work{0}, interrupted{0};  // overruns by cause

 private:
  std::uint32_t operator_bits() noexcept;
  bool probe_begins(const loop::TickTiming& timing) noexcept;
  void count(loop::OverrunCause cause) noexcept;
  void show(const loop::TickOutput& out) noexcept;

  Session& session_;
  loop::TimedTick<hal::AnyDevice, hal::GpioLines> tick_;
  loop::TickProbe* probe_;
  RealtimeTaps taps_;
  LiveStatus& live_;
  std::atomic<std::uint32_t>& requests_;
  ArmGate& gate_;
  std::uint64_t most_ticks_;
  std::int64_t period_ns_;
  bool real_;  // the device outlives the run
  std::uint64_t end_ticks_, ended_ticks_{0};
  std::atomic<bool> ending_{false};
};

}  // namespace tactus::session
