// A run on a virtual clock: device, loop and global world in one thread. No time is measured, so the same options give
// the same bits. The duration of a global step comes from a fixed cost table; a stall adds to it.
// Thread: normal.
#pragma once

#include <functional>
#include <optional>

#include "tools/session/session.h"

namespace tactus::session {

// Called after each tick of a virtual run; returns false to end it. For tests and progress display.
using TickObserver = std::function<bool(const loop::TickOutput&)>;

// Duration of a global step by the cost table, from its counts [ns]; collision detection included.
double global_step_ns(const sim::GlobalStatistics& last, std::uint32_t sub_steps) noexcept;

// Runs a session tick by tick. The calling thread must flush denormals (rt/base/denormals.h). The session must outlive
// it.
class VirtualRun {
 public:
  // Publishes the first snapshot, G(0). Only once per session, because it starts the worlds.
  explicit VirtualRun(Session& session);

  // [setup] Checks that the threads which share the global world's steps exist.
  static Status check(const Session& session);

  // One tick; `asked`: OperatorBits in addition to the session's own. Allocates only for a reset and for a tape.
  const loop::TickOutput& tick(std::uint32_t asked = 0);

  // [setup] Everything that the following ticks depend on, a device of the caller's own apart: for restore() of the
  // same run, or of one of the same scene and options, without a tape. Both copy the whole state, megabytes.
  struct Saved;
  std::shared_ptr<const Saved> save() const;
  void restore(const Saved& saved);

 private:
  struct Clock {
    std::uint64_t tick{0};
    std::size_t next_stall{0};
    std::uint64_t ready_tick{0};  // when the global world has finished the current report
    bool busy{false};
  };

  void serve_world();
  std::uint64_t step_ticks() const;
  std::uint64_t stall_ticks();

  Session& session_;
  std::optional<sim::SnapshotServer> server_;  // none with the direct coupling
  Clock clock_;
};

// Error: of the threads that share the global world's steps. `observer` may be empty.
Result<RunSummary> run_virtual(Session& session, std::uint64_t ticks, const TickObserver& observer = {});

}  // namespace tactus::session
