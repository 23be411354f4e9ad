#include "tools/session/virtual_run.h"

#include "rt/base/denormals.h"
#include "rt/loop/timed_tick.h"

namespace tactus::session {

double global_step_ns(const sim::GlobalStatistics& last, std::uint32_t sub_steps) noexcept {
  const loop::WorkCounts counts{.bodies = last.awake,
                                .pairs = last.pairs,
                                .contacts = last.contacts,
                                .points = last.points,
                                .searched = last.comparisons};
  return predict_ns(loop::CostModel{}, counts, sub_steps);
}

VirtualRun::VirtualRun(Session& session) : session_(session) {
  if (session.global == nullptr) return;
  server_.emplace(*session.global, *session.exchange);
  server_->publish_first();
}

Status VirtualRun::check(const Session& session) {
  return session.workers == nullptr ? Status::good() : session.workers->status();
}

const loop::TickOutput& VirtualRun::tick(std::uint32_t asked) {
  if (server_) serve_world();
  // Made here because Session::record replaces the driver.
  loop::TimedTick<hal::AnyDevice, loop::NoLines, loop::VirtualClock> timed_tick(*session_.driver, 0);
  timed_tick({}, [&]() noexcept { return session_.operator_bits(asked); });
  session_.count_tick();
  if (session_.drain != nullptr && clock_.tick % 64 == 0) session_.drain->drain();
  ++clock_.tick;
  return session_.driver->output();
}

void VirtualRun::serve_world() {
  if (!server_->has_report()) return;
  if (!clock_.busy) {
    clock_.busy = true;
    clock_.ready_tick = clock_.tick + step_ticks() + stall_ticks();
  }
  if (clock_.tick < clock_.ready_tick) return;
  server_->serve();
  clock_.busy = false;
}

std::uint64_t VirtualRun::step_ticks() const {
  const double cost_ns =
      global_step_ns(session_.global->statistics(), session_.scene.solver.global_sub_steps(session_.ratio));
  return static_cast<std::uint64_t>(cost_ns / (session_.options.period_s() * 1e9));
}

std::uint64_t VirtualRun::stall_ticks() {
  std::uint64_t ticks = 0;
  while (clock_.next_stall < session_.stalls.size() && session_.stalls[clock_.next_stall].at_tick <= clock_.tick)
    ticks += session_.stalls[clock_.next_stall++].ticks;
  return ticks;
}

Result<RunSummary> run_virtual(Session& session, std::uint64_t ticks, const TickObserver& observer) {
  set_denormals_flush();
  if (Status status = VirtualRun::check(session); !status.ok()) return status;
  VirtualRun run(session);
  for (std::uint64_t tick = 0; tick < ticks; ++tick) {
    const loop::TickOutput& out = run.tick();
    if (observer && !observer(out)) break;
  }
  RunSummary summary = session.summary();
  session.close_tape(summary);
  return summary;
}

}  // namespace tactus::session
