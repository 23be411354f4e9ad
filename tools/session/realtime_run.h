// A run in real time: the haptic thread on its core, the global world on its own, this thread for the screen and the
// keyboard. Thread: the main one.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <string>

#include "rt/loop/tick_probe.h"
#include "tools/session/session.h"

namespace tactus::session {

// What the screen shows while it runs. Written by the haptic thread, each value by itself.
struct LiveStatus {
  std::atomic<std::uint64_t> ticks{0}, overruns{0}, late_cycles{0}, fault_count{0};
  std::atomic<double> force_N{0};
  std::atomic<std::uint32_t> members{0}, contacts{0}, border{0}, status{0}, fault{0}, resets{0};
  std::atomic<std::uint32_t> device_state{0}, device_fault{0}, device_limits{0};  // what the device says of itself
  std::atomic<std::uint32_t> fault_state{0}, fault_limits{0};                     // when the fault latched
};

// The latched fault with what the device says of it; empty if none is.
std::string fault_line(const LiveStatus& live);

// Beside the haptic thread and the global world's: called by them, so functions with their context.
struct RealtimeTaps {
  // [rt] After each tick of the loop, by the haptic thread: no allocation, lock, wait, log or throw.
  void (*ticked)(void* context, const Driver& driver) noexcept {nullptr};
  // After each step, by the global world's thread, which waits for it.
  void (*stepped)(void* context, const sim::GlobalWorld& world) noexcept {nullptr};
  void* context{nullptr};
};

struct RealtimeHooks {
  // Called every `look_every` by the calling thread. Returns false to end the run.
  std::function<bool(const LiveStatus&, double elapsed_s)> show;
  // OperatorBit: what the operator asked for since the last call.
  std::function<std::uint32_t()> asked;
  // OperatorBit: what others ask of the loop, set by them and taken once; null: nobody does.
  std::atomic<std::uint32_t>* requests{nullptr};
  // Lines for people, such as why a re-arm was refused; null: nobody reads them. By the calling thread.
  std::function<void(const std::string&)> say;
  // Looks into every tick, and may take windows for itself; null: nobody does.
  loop::TickProbe* probe{nullptr};
  RealtimeTaps taps{};
  std::chrono::milliseconds look_every{200};
};

// Returns when the duration is over, a hook or `stop` ends it. The error is the system's or the tape's.
Result<RunSummary> run_realtime(Session& session, const RealtimeHooks& hooks, const std::atomic<bool>& stop);

}  // namespace tactus::session
