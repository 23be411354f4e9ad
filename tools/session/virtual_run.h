// A run on a virtual clock: device, loop and global world in one thread, nothing measured, so the same options give the
// same bits. The global world takes the time that a fixed cost table says; a stall adds to it.
// Thread: normal.
#pragma once

#include <functional>
#include <optional>

#include "tools/session/session.h"

namespace tactus::session {

// After each tick of a virtual run; returns false to end it. For tests and for progress.
using TickObserver = std::function<bool(const loop::TickOutput&)>;

// What the cost table says a global step took, by its counts [ns], searching for contacts included.
double global_step_ns(const sim::GlobalStatistics& last, std::uint32_t sub_steps) noexcept;

// The run tick by tick. The thread must flush denormals (rt/base/denormals.h) while it calls. The session outlives it.
class VirtualRun {
 public:
  // G(0) is published. Once for each session: its worlds have then begun.
  explicit VirtualRun(Session& session);

  // [setup] The threads that share the global world's steps are there.
  static Status check(const Session& session);

  // One tick; `asked`: bits of the operator beside the session's own. Allocates nothing but for a reset and a tape.
  const loop::TickOutput& tick(std::uint32_t asked = 0);

 private:
  void serve_world();
  std::uint64_t step_ticks() const;
  std::uint64_t stall_ticks();

  Session& session_;
  std::optional<sim::SnapshotServer> server_;  // none with the direct coupling
  std::uint64_t tick_{0};
  std::size_t next_stall_{0};
  std::uint64_t ready_tick_{0};  // when the global world is done with the report that it has
  bool busy_{false};
};

// The error is that of the threads that share the global world's steps. `observer` may be empty.
Result<RunSummary> run_virtual(Session& session, std::uint64_t ticks, const TickObserver& observer = {});

}  // namespace tactus::session
