#include "tools/session/realtime_tick.h"

#include <cmath>

namespace tactus::session {

RealtimeTick::RealtimeTick(Session& session, const SharedWithRun& shared, std::uint64_t most_ticks,
                           loop::TickProbe* probe, const RealtimeTaps& taps)
    : session_(session),
      tick_(*session.driver, static_cast<std::int64_t>(session.options.period_s() * 1e9), session.gpio.get(), probe),
      probe_(probe),
      taps_(taps),
      live_(shared.live),
      requests_(shared.requests),
      gate_(shared.gate),
      most_ticks_(most_ticks),
      real_(session.simulated() == nullptr),
      end_ticks_(static_cast<std::uint64_t>(std::llround(kEnd_s * session.options.rate_Hz))) {}

bool RealtimeTick::operator()(const loop::TickTiming& timing) noexcept {
  if (probe_ != nullptr && !probe_begins(timing)) return true;
  const loop::TickAccount account = tick_(timing, [this]() noexcept { return operator_bits(); });
  const Driver& driver = *session_.driver;
  compute.record(account.compute_ns);
  device.record(account.device_ns);
  cost_prediction.add(driver.plan().predicted_ns, static_cast<double>(account.compute_ns));
  if (account.overrun) count(*account.overrun);
  session_.count_tick();
  if (taps_.ticked != nullptr) taps_.ticked(taps_.context, driver);
  show(timing, driver.output());
  return session_.stats.ticks < most_ticks_ && ended_ticks_ < end_ticks_;
}

// OperatorBits for this tick, from all sources.
std::uint32_t RealtimeTick::operator_bits() noexcept {
  constexpr auto relaxed = std::memory_order_relaxed;
  const std::uint32_t requests = requests_.load(relaxed) != 0 ? requests_.exchange(0, relaxed) : 0u;
  std::uint32_t bits = gate_.pass(session_.operator_bits(requests));
  if (real_ && (ending_.load(relaxed) || session_.stats.ticks + end_ticks_ >= most_ticks_)) {
    bits |= loop::kEnd;
    ++ended_ticks_;
  }
  return bits;
}

// Returns false if the probe has claimed this window.
bool RealtimeTick::probe_begins(const loop::TickTiming& timing) noexcept {
  switch (probe_->window(timing)) {
    case loop::WindowKind::kLoop:
      probe_->begin(timing);
      return true;
    case loop::WindowKind::kBare:
      probe_->bare(timing);
      return false;
    case loop::WindowKind::kRest:
      probe_->rest(timing, tick_.period_ns());
      return false;
  }
  return true;
}

void RealtimeTick::count(loop::OverrunCause cause) noexcept {
  switch (cause) {
    case loop::OverrunCause::kLateWake:
      ++late_wake;
      break;
    case loop::OverrunCause::kOwnWork:
      ++own_work;
      break;
    case loop::OverrunCause::kInterrupted:
      ++interrupted;
      break;
  }
}

void RealtimeTick::show(const loop::TickTiming& timing, const loop::TickOutput& out) noexcept {
  constexpr auto relaxed = std::memory_order_relaxed;
  live_.overruns.store(late_wake + own_work + interrupted, relaxed);
  live_.late_wake.store(late_wake, relaxed);
  live_.own_work.store(own_work, relaxed);
  live_.interrupted.store(interrupted, relaxed);
  if (timing.health != nullptr) live_.skipped.store(timing.health->skipped_ticks, relaxed);
  live_.show(session_, out);
}

void LiveStatus::show(const Session& session, const loop::TickOutput& out) noexcept {
  constexpr auto relaxed = std::memory_order_relaxed;
  ticks.store(session.stats.ticks, relaxed);
  late_cycles.store(session.stats.late_cycles, relaxed);
  force_N.store(norm(out.command.wrench.force), relaxed);
  members.store(out.members, relaxed);
  contacts.store(out.contacts, relaxed);
  border.store(out.border, relaxed);
  status.store(out.status, relaxed);
  const haptics::DeviceSample& sample = session.driver->sample();
  device_state.store(static_cast<std::uint32_t>(sample.state), relaxed);
  device_limits.store(sample.limits, relaxed);
  if (out.fault == Fault::kNone || sample.device_fault != 0) device_fault.store(sample.device_fault, relaxed);
  if (static_cast<std::uint32_t>(out.fault) != fault.load(relaxed)) {
    fault_state.store(static_cast<std::uint32_t>(sample.state), relaxed);
    fault_limits.store(sample.limits, relaxed);
  }
  fault_count.store(session.stats.fault_count, relaxed);
  fault.store(static_cast<std::uint32_t>(out.fault), relaxed);
  resets.store(session.loop->sub_world().epoch(), relaxed);
}

}  // namespace tactus::session
