// A run on a virtual clock: device, loop and global world in one thread. No time is measured, so the same options give
// the same bits. The duration of a global step comes from a fixed cost table; a stall adds to it.
// Thread: normal.
#pragma once

#include <functional>
#include <optional>
#include <span>

#include "tools/session/hands.h"

namespace tactus::session {

// Called after each tick of a virtual run; returns false to end it. For tests and progress display.
using TickObserver = std::function<bool(const loop::TickOutput&)>;

// Duration of a global step by the cost table, from its counts [ns]; collision detection and the prediction of the
// sub-world over `ratio` ticks included.
double global_step_ns(const sim::GlobalStatistics& last, std::uint32_t sub_steps, unsigned ratio) noexcept;

// The global world on the virtual clock.
class VirtualWorld {
 public:
  // Publishes the first snapshot, G(0), to each of the exchanges. `first`: of the hands, whose script has the stalls.
  VirtualWorld(Session& first, std::vector<haptics::Exchange*> exchanges);

  // Before each tick, of all hands.
  void serve(std::uint64_t tick);

  struct Clock {
    std::size_t next_stall{0};
    std::uint64_t ready_tick{0};  // when the global world has finished the current report
    bool busy{false};
  };
  const Clock& clock() const noexcept { return clock_; }
  std::uint64_t next_report() const noexcept { return server_.next_report(); }
  // [setup] `next_report`: the same of all hands, because on the virtual clock none is left out.
  void continue_at(const Clock& clock, std::uint64_t next_report) noexcept;

 private:
  std::uint64_t step_ticks() const;
  std::uint64_t stall_ticks(std::uint64_t tick);

  Session& session_;
  sim::SnapshotServer server_;
  Clock clock_;
};

// Runs one hand or several tick by tick; in each tick one hand after the other, in their order. The calling thread must
// flush denormals (rt/base/denormals.h). The sessions must outlive it.
class VirtualRun {
 public:
  // Publishes the first snapshot, G(0). Only once per session, because it starts the worlds.
  explicit VirtualRun(Session& session);
  explicit VirtualRun(Hands& hands);

  // [setup] Checks that the threads which share the global world's steps exist.
  static Status check(const Session& session);

  // One tick; `asked`: OperatorBits by hand in addition to the session's own; shorter: none. Allocates only for a reset
  // and for a tape.
  void tick(std::span<const std::uint32_t> asked);
  // The same with the bits of the first hand, whose output it returns.
  const loop::TickOutput& tick(std::uint32_t asked = 0);

  // [setup] save() returns the whole state on which the following ticks depend, except that of a device of the caller.
  // restore() takes it into the same run, or into one of the same scene and options, that records no tape. Both copy
  // some megabytes.
  struct Saved;
  std::shared_ptr<const Saved> save() const;
  void restore(const Saved& saved);

 private:
  explicit VirtualRun(std::vector<Session*> hands);

  std::vector<Session*> hands_;
  std::optional<VirtualWorld> world_;  // none with the direct coupling
  std::uint64_t tick_{0};
};

// Error: of the threads that share the global world's steps. `observer` may be empty.
Result<RunSummary> run_virtual(Session& session, std::uint64_t ticks, const TickObserver& observer = {});
// The same for several hands: a summary for each.
using HandsObserver = std::function<bool(const Hands& hands)>;
Result<std::vector<RunSummary>> run_virtual(Hands& hands, std::uint64_t ticks, const HandsObserver& observer = {});

}  // namespace tactus::session
