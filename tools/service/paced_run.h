// A run in virtual time at the pace that its operator asks for (pacing.h), watched and controlled like one in real
// time.
//
// The clock is virtual: measured time decides when a tick is computed, never what it computes. Thread: main. Bound:
// while it is stopped, it looks for requests every kLook_ms.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "sim/global_thread.h"
#include "tools/service/pacing.h"
#include "tools/session/realtime_tick.h"
#include "tools/session/virtual_run.h"

namespace tactus::service {

struct PacedHooks {
  Pacing& pacing;
  std::atomic<std::uint32_t>& requests;  // OperatorBit: set by others, taken here
  const std::atomic<bool>& stop;
  // After steps of the global world, and while the run is stopped; `context` is the caller's.
  void (*stepped)(void* context, const sim::GlobalWorld& world) noexcept {nullptr};
  void* context{nullptr};
  // Five times a second.
  std::function<void(const session::LiveStatus& live, double elapsed_s)> look;
};

// `run`: of the session, begun by the caller. `ticks`: 0: until stopped. Error: of the threads that share the global
// world's steps.
Result<session::RunSummary> run_paced(session::Session& session, session::VirtualRun& run, const PacedHooks& hooks,
                                      std::uint64_t ticks);

// The same for several hands: one pace, the requests of each.
struct PacedHandsHooks {
  Pacing& pacing;
  std::vector<std::atomic<std::uint32_t>*> requests;  // by hand
  const std::atomic<bool>& stop;
  sim::StepObserver stepped{};
  std::function<void(std::span<const session::LiveStatus* const> hands, double elapsed_s)> look;
};
Result<std::vector<session::RunSummary>> run_paced(session::Hands& hands, const PacedHandsHooks& hooks,
                                                   std::uint64_t ticks);

}  // namespace tactus::service
