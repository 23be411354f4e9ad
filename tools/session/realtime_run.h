// Runs a session in real time: the haptic thread on its core, the global world on another thread, and the calling
// thread for display and keyboard. With several hands there is a haptic thread for each. Thread: main.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <string>

#include "sim/global_thread.h"
#include "tools/session/hands.h"
#include "tools/session/realtime_tick.h"

namespace tactus::session {

// Describes the latched fault and the device's state at that time; empty if none is latched.
std::string fault_line(const LiveStatus& live);

struct RealtimeHooks {
  // Called every `look_every` by the calling thread. Returns false to end the run.
  std::function<bool(const LiveStatus&, double elapsed_s)> show;
  // Called once by the calling thread when the haptic thread runs: what of its set-up succeeded. Optional.
  std::function<void(const loop::SetupReport&)> began;
  // OperatorBit: requests of the operator since the last call.
  std::function<std::uint32_t()> asked;
  // OperatorBit: requests of other threads; each bit is set by them and cleared when it is read. Optional.
  std::atomic<std::uint32_t>* requests{nullptr};
  // Prints messages, such as why a re-arm was refused. Called by the calling thread. Optional.
  std::function<void(const std::string&)> say;
  // Observes every tick and may claim windows for its own measurements. Optional.
  loop::TickProbe* probe{nullptr};
  RealtimeTaps taps{};
  std::chrono::milliseconds look_every{200};
};

// Of one hand of several; each as in RealtimeHooks, and optional.
struct HandHooks {
  std::function<void(const loop::SetupReport&)> began;
  std::atomic<std::uint32_t>* requests{nullptr};
  loop::TickProbe* probe{nullptr};
  RealtimeTaps taps{};  // without `stepped`
};

// Of all hands together; each as in RealtimeHooks.
struct HandsHooks {
  std::function<bool(std::span<const LiveStatus* const> hands, double elapsed_s)> show;
  std::function<std::uint32_t()> asked;  // of every hand
  std::function<void(const std::string&)> say;
  sim::StepObserver stepped{};
  std::chrono::milliseconds look_every{200};
  std::vector<HandHooks> hands{};  // by hand; may be shorter
};

// The tape of a fault's last seconds, in the working directory; that of a further hand: file_of_hand.
inline constexpr const char* kFaultTape = "tactus-fault.tape";
std::filesystem::path fault_tape_of(const Session& session);
// Writes the flight recorder's last seconds there, in place of an older tape, whose readers keep what they have open.
// Also during the run, from any thread of normal priority. Error: of the disk, or nothing was recorded yet.
Status write_fault_tape(const Session& session);

// Returns when the duration is over, or when a hook or `stop` ends the run. Errors: of the operating system or the
// tape.
Result<RunSummary> run_realtime(Session& session, const RealtimeHooks& hooks, const std::atomic<bool>& stop);
// The same for several hands: a summary for each.
Result<std::vector<RunSummary>> run_realtime(Hands& hands, const HandsHooks& hooks, const std::atomic<bool>& stop);

}  // namespace tactus::session
