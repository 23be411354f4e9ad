// The body of the haptic thread in real time: one timed tick of the loop (rt/loop/timed_tick.h), the operator's
// requests, the statistics of the run, and the values for the display. Tests that check real-time safety run this
// class.
//
// Thread: construction, end() [normal]; statistics [normal], after the haptic thread has ended; operator() [rt].
#pragma once

#include <atomic>
#include <cstdint>

#include "rt/base/histogram.h"
#include "rt/loop/timed_tick.h"
#include "tools/session/arm_gate.h"
#include "tools/session/session.h"

namespace tactus::session {

// Duration of the end of a run on a real device: the force fades out and IDLE is commanded, so that the device does not
// stop by its watchdog.
inline constexpr double kEnd_s = 2 * loop::kEndFade_s;

// Values for the display during a run. Written by the thread that runs the loop, each independently of the others.
struct LiveStatus {
  // [rt] Takes the values after a tick, apart from those of the deadlines.
  void show(const Session& session, const loop::TickOutput& out) noexcept;

  std::atomic<std::uint64_t> ticks{0}, overruns{0}, late_cycles{0}, fault_count{0};
  std::atomic<std::uint64_t> late_wake{0}, own_work{0}, interrupted{0};  // overruns by cause
  std::atomic<std::uint64_t> skipped{0};                                 // deadlines without a tick
  std::atomic<double> force_N{0};
  std::atomic<std::uint32_t> members{0}, contacts{0}, border{0}, status{0}, fault{0}, resets{0};
  std::atomic<std::uint32_t> device_state{0}, device_fault{0}, device_limits{0};  // reported by the device
  std::atomic<std::uint32_t> fault_state{0}, fault_limits{0};  // reported by the device when the fault latched
};

// Callbacks made by the haptic thread and by the global world's thread, as function pointers with a context.
struct RealtimeTaps {
  // [rt] After each tick of the loop, by the haptic thread: no allocation, lock, wait, log or throw.
  void (*ticked)(void* context, const Driver& driver) noexcept {nullptr};
  // After each step, by the global world's thread, which waits for its return.
  void (*stepped)(void* context, const sim::GlobalWorld& world) noexcept {nullptr};
  void* context{nullptr};
};

// What the haptic thread shares with the thread that attends the run. Must outlive the RealtimeTick.
struct SharedWithRun {
  LiveStatus& live;
  std::atomic<std::uint32_t>& requests;  // OperatorBit
  ArmGate& gate;
};

class RealtimeTick {
 public:
  // `probe`: observes every tick and may claim windows for its own measurements; may be null.
  RealtimeTick(Session& session, const SharedWithRun& shared, std::uint64_t most_ticks,
               loop::TickProbe* probe = nullptr, const RealtimeTaps& taps = {});

  // Returns false after the last tick.
  bool operator()(const loop::TickTiming& timing) noexcept;

  // [normal] Requests the end: the loop stops after the force has faded and the device has had time to enter IDLE.
  void end() noexcept { ending_.store(true, std::memory_order_relaxed); }
  bool must_end() const noexcept { return real_; }
  // [setup] See TimedTick.
  void cut_at(std::uint32_t sweep) noexcept { tick_.cut_at(sweep); }

  Histogram compute, device;
  loop::CostPredictionStats cost_prediction;
  std::uint64_t late_wake{0}, own_work{0}, interrupted{0};  // overruns by cause

 private:
  std::uint32_t operator_bits() noexcept;
  bool probe_begins(const loop::TickTiming& timing) noexcept;
  void count(loop::OverrunCause cause) noexcept;
  void show(const loop::TickTiming& timing, const loop::TickOutput& out) noexcept;

  Session& session_;
  loop::TimedTick<hal::AnyDevice, hal::HandLines> tick_;
  loop::TickProbe* probe_;
  RealtimeTaps taps_;
  LiveStatus& live_;
  std::atomic<std::uint32_t>& requests_;
  ArmGate& gate_;
  std::uint64_t most_ticks_;
  bool real_;  // the device is real and continues after the run
  std::uint64_t end_ticks_, ended_ticks_{0};
  std::atomic<bool> ending_{false};
};

}  // namespace tactus::session
