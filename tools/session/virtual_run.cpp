#include "tools/session/virtual_run.h"

#include "rt/base/denormals.h"

namespace tactus::session {
namespace {

// When the global world is done with the report that it has, on the virtual clock.
class VirtualWorld {
 public:
  explicit VirtualWorld(Session& session) : session_(session), server_(*session.global, *session.exchange) {
    server_.publish_first();
  }

  void before_tick(std::uint64_t tick) {
    if (!server_.has_report()) return;
    if (!busy_) {
      busy_ = true;
      ready_tick_ = tick + step_ticks() + stall_ticks(tick);
    }
    if (tick < ready_tick_) return;
    server_.serve();
    busy_ = false;
  }

 private:
  std::uint64_t step_ticks() const {
    const double cost_ns =
        global_step_ns(session_.global->statistics(), session_.scene.solver.global_sub_steps(session_.ratio));
    return static_cast<std::uint64_t>(cost_ns / (session_.options.period_s() * 1e9));
  }

  std::uint64_t stall_ticks(std::uint64_t tick) {
    std::uint64_t ticks = 0;
    while (next_stall_ < session_.stalls.size() && session_.stalls[next_stall_].at_tick <= tick)
      ticks += session_.stalls[next_stall_++].ticks;
    return ticks;
  }

  Session& session_;
  sim::SnapshotServer server_;
  std::size_t next_stall_{0};
  std::uint64_t ready_tick_{0};
  bool busy_{false};
};

}  // namespace

double global_step_ns(const sim::GlobalStatistics& last, std::uint32_t sub_steps) noexcept {
  const loop::WorkCounts counts{.bodies = last.awake,
                                .pairs = last.pairs,
                                .contacts = last.contacts,
                                .points = last.points,
                                .searched = last.comparisons};
  return predict_ns(loop::CostModel{}, counts, sub_steps);
}

Result<RunSummary> run_virtual(Session& session, std::uint64_t ticks, const TickObserver& observer) {
  set_denormals_flush();
  std::optional<VirtualWorld> world;
  if (session.global != nullptr) {
    if (const Status& status = session.workers->status(); !status.ok()) return status;
    world.emplace(session);
  }
  for (std::uint64_t tick = 0; tick < ticks; ++tick) {
    if (world) world->before_tick(tick);
    session.driver->read();
    const loop::TickOutput& out = session.driver->compute(session.operator_bits(), {});
    session.driver->write();
    session.count_tick();
    if (session.drain != nullptr && tick % 64 == 0) session.drain->drain();
    if (observer && !observer(out)) break;
  }
  RunSummary summary = session.summary();
  session.close_tape(summary);
  return summary;
}

}  // namespace tactus::session
