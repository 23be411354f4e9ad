// A run in real time: the haptic thread on its core, the global world on its own, this thread for the screen and the
// keyboard. Thread: the main one.
#pragma once

#include <atomic>
#include <functional>

#include "rt/loop/tick_probe.h"
#include "tools/session/session.h"

namespace tactus::session {

// What the screen shows while it runs. Written by the haptic thread, each value by itself.
struct LiveStatus {
  std::atomic<std::uint64_t> ticks{0}, overruns{0}, late_cycles{0};
  std::atomic<double> force_N{0};
  std::atomic<std::uint32_t> members{0}, contacts{0}, border{0}, status{0}, fault{0}, resets{0};
};

struct RealtimeHooks {
  // Called about five times a second by the calling thread. Returns false to end the run.
  std::function<bool(const LiveStatus&, double elapsed_s)> show;
  // OperatorBit: what the operator asked for since the last call.
  std::function<std::uint32_t()> asked;
  // OperatorBit: what others ask of the loop, set by them and taken once; null: nobody does.
  std::atomic<std::uint32_t>* requests{nullptr};
  // Looks into every tick, and may take windows for itself; null: nobody does.
  loop::TickProbe* probe{nullptr};
};

// Returns when the duration is over, a hook or `stop` ends it. The error is the system's or the tape's.
Result<RunSummary> run_realtime(Session& session, const RealtimeHooks& hooks, const std::atomic<bool>& stop);

}  // namespace tactus::session
