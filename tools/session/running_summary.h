// The summary of a run so far, for its verdict: counted from the recorder's records, as the run itself counts its
// ticks.
//
// The run's own statistics belong to the haptic thread until it has ended, whereas the records reach normal threads.
// The verdict of a tape is computed from the same counts.
// Thread: take: the one that takes the records; take_world: the global world's, which never waits here; the rest [any].
// Bound: constant work a record.
#pragma once

#include <cstdint>
#include <mutex>
#include <span>

#include "tools/session/realtime_tick.h"
#include "tools/session/summary.h"

namespace tactus::session {

class RunningSummary {
 public:
  // Before the session's first tick; it must outlive this object.
  explicit RunningSummary(const Session& session) : scene_(session.scene), start_(session.summary()) {}

  // Every record as the recorder's ring gives it.
  void take(std::uint32_t kind, std::span<const std::byte> payload) noexcept;
  void take(const loop::TickRecord& tick) noexcept;
  // After a step. During a so_far() of another thread nothing is taken: the next step brings newer values.
  void take_world(const sim::GlobalStatistics& statistics) noexcept;
  // Of real time, once the haptic thread runs.
  void take_setup(const loop::SetupReport& setup);

  // All that the rules of verdict.h look at, up to now.
  RunSummary so_far() const;
  // The same with what only the haptic thread counts: lost deadlines and their causes.
  RunSummary so_far(const LiveStatus& live) const;

 private:
  const sim::Scene& scene_;
  mutable std::mutex mutex_, world_mutex_;
  RunSummary start_;  // without counts
  loop::RunStats stats_;
  sim::GlobalStatistics world_;
  std::uint32_t cycle_ticks_{0};
};

}  // namespace tactus::session
