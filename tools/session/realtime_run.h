// A run in real time: the haptic thread on its core, the global world on its own, this thread for the screen and the
// keyboard. Thread: the main one.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <string>

#include "tools/session/realtime_tick.h"

namespace tactus::session {

// The latched fault with what the device says of it; empty if none is.
std::string fault_line(const LiveStatus& live);

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
