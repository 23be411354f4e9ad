#include "tools/session/virtual_run.h"

#include "rt/base/denormals.h"
#include "rt/loop/timed_tick.h"

namespace tactus::session {

double global_step_ns(const sim::GlobalStatistics& last, std::uint32_t sub_steps, unsigned ratio) noexcept {
  const loop::WorkCounts counts{.bodies = last.awake,
                                .pairs = last.pairs,
                                .contacts = last.contacts,
                                .points = last.points,
                                .comparisons = last.comparisons};
  const sim::PredictionWork& tick = last.prediction;
  const loop::WorkCounts predicted{.bodies = tick.members,
                                   .pairs = tick.pairs,
                                   .contacts = tick.contacts,
                                   .points = tick.points,
                                   .border = tick.border,
                                   .comparisons = tick.comparisons};
  const double prediction_ns = tick.members == 0 ? 0 : ratio * predict_ns(loop::CostModel{}, predicted, tick.sub_steps);
  return predict_ns(loop::CostModel{}, counts, sub_steps) + prediction_ns;
}

VirtualWorld::VirtualWorld(Session& first, std::vector<haptics::Exchange*> exchanges)
    : session_(first), server_(*first.global, std::move(exchanges)) {
  server_.publish_first();
}

void VirtualWorld::serve(std::uint64_t tick) {
  if (!server_.has_report()) return;
  if (!clock_.busy) {
    clock_.busy = true;
    clock_.ready_tick = tick + step_ticks() + stall_ticks(tick);
  }
  if (tick < clock_.ready_tick) return;
  server_.serve();
  clock_.busy = false;
}

std::uint64_t VirtualWorld::step_ticks() const {
  const double cost_ns = global_step_ns(session_.global->statistics(), session_.global->sub_steps(), session_.ratio);
  return static_cast<std::uint64_t>(cost_ns / (session_.options.period_s() * 1e9));
}

std::uint64_t VirtualWorld::stall_ticks(std::uint64_t tick) {
  std::uint64_t ticks = 0;
  while (clock_.next_stall < session_.stalls.size() && session_.stalls[clock_.next_stall].at_tick <= tick)
    ticks += session_.stalls[clock_.next_stall++].ticks;
  return ticks;
}

void VirtualWorld::continue_at(const Clock& clock, std::uint64_t next_report) noexcept {
  clock_ = clock;
  server_.continue_at(next_report);
}

VirtualRun::VirtualRun(Session& session) : VirtualRun(std::vector{&session}) {}

VirtualRun::VirtualRun(Hands& hands) : VirtualRun(hands.sessions()) {}

VirtualRun::VirtualRun(std::vector<Session*> hands) : hands_(std::move(hands)) {
  Session& first = *hands_.front();
  if (first.global == nullptr) return;
  std::vector<haptics::Exchange*> exchanges;
  for (const Session* hand : hands_) exchanges.push_back(hand->exchange.get());
  world_.emplace(first, std::move(exchanges));
}

Status VirtualRun::check(const Session& session) {
  return session.workers == nullptr ? Status::good() : session.workers->status();
}

namespace {

void tick_of(Session& session, std::uint64_t tick, std::uint32_t asked) {
  // Made here because Session::record replaces the driver.
  loop::TimedTick<hal::AnyDevice, loop::NoLines, loop::VirtualClock> timed_tick(*session.driver, 0);
  timed_tick({}, [&]() noexcept { return session.operator_bits(asked); });
  session.count_tick();
  if (session.drain != nullptr && tick % 64 == 0) session.drain->drain();
}

}  // namespace

void VirtualRun::tick(std::span<const std::uint32_t> asked) {
  if (world_) world_->serve(tick_);
  for (std::size_t hand = 0; hand < hands_.size(); ++hand)
    tick_of(*hands_[hand], tick_, hand < asked.size() ? asked[hand] : 0);
  ++tick_;
}

const loop::TickOutput& VirtualRun::tick(std::uint32_t asked) {
  tick({&asked, 1});
  return hands_.front()->driver->output();
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

Result<std::vector<RunSummary>> run_virtual(Hands& hands, std::uint64_t ticks, const HandsObserver& observer) {
  set_denormals_flush();
  if (Status status = VirtualRun::check(hands[0]); !status.ok()) return status;
  VirtualRun run(hands);
  for (std::uint64_t tick = 0; tick < ticks; ++tick) {
    run.tick();
    if (observer && !observer(hands)) break;
  }
  std::vector<RunSummary> summaries;
  for (unsigned hand = 0; hand < hands.count(); ++hand) {
    summaries.push_back(hands[hand].summary());
    hands[hand].close_tape(summaries.back());
  }
  return summaries;
}

}  // namespace tactus::session
