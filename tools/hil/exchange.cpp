#include "tools/hil/exchange.h"

#include <chrono>
#include <cmath>
#include <limits>
#include <thread>

#include "rt/base/clock.h"

namespace tactus::hil {
namespace {

// 29 s of records at 1 kHz: enough for the time in which the operator reads a question or a command causes a fault.
constexpr std::uint64_t kRingBytes = 8u << 20;
constexpr std::uint64_t kRearmRises =
    2;  // tick in which the flag rises; the device must first have received it cleared

hal::LinkCounters since(const hal::LinkCounters& now, const hal::LinkCounters& before) noexcept {
  return {.received = now.received - before.received,
          .superseded = now.superseded - before.superseded,
          .malformed = now.malformed - before.malformed,
          .sent = now.sent - before.sent,
          .send_superseded = now.send_superseded - before.send_superseded,
          .send_failed = now.send_failed - before.send_failed,
          .errors = now.errors - before.errors,
          .disconnects = now.disconnects - before.disconnects};
}

// Passes records from the ring to the director and the result.
class Reader {
 public:
  Reader(ExchangeTick& tick, const Director& director, bool keep, ExchangeResult& result)
      : tick_(tick), director_(director), keep_(keep), result_(result) {}

  // False: the director requests the end.
  bool drain() {
    RingRecord header;
    Record record;
    while (tick_.records().try_pop(header, std::as_writable_bytes(std::span(&record, 1))) == Pop::kRecord) {
      result_.dropped_records += header.lost_before;
      if (keep_) result_.records.push_back(record);
      if (stopped_ || !director_) continue;
      const Next next = director_(record);
      // The phase advances only once, although further records of the ended phase follow: the haptic thread is ahead of
      // this reader.
      if (next == Next::kNextPhase && record.phase >= asked_) tick_.ask_for_phase(asked_ = record.phase + 1);
      if (next == Next::kStop) stopped_ = true;
    }
    return !stopped_;
  }

 private:
  ExchangeTick& tick_;
  const Director& director_;
  bool keep_;
  ExchangeResult& result_;
  std::uint32_t asked_{0};
  bool stopped_{false};
};

void run_stepped(ExchangeTick& tick, Reader& reader) {
  loop::TimingHealth health;
  loop::TickTiming timing;
  timing.health = &health;
  for (bool go = true; go; ++timing.tick) {
    go = tick(timing);
    if (!reader.drain()) return;
  }
}

Status run_on_thread(ExchangeTick& tick, Reader& reader, const ExchangeSettings& settings, ExchangeResult& result) {
  loop::PeriodicSettings periodic;
  periodic.period = std::chrono::nanoseconds(settings.period_ns);
  periodic.setup = settings.setup;
  loop::PeriodicThread<ExchangeTick> thread(tick);
  if (const Status status = thread.start(periodic); !status.ok()) return status;
  while (thread.running() && reader.drain()) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  thread.stop();
  reader.drain();
  result.setup = thread.setup_report();
  result.timing = thread.health();
  return Status::good();
}

}  // namespace

ExchangeTick::ExchangeTick(hal::AnyLink& link, Conversation& conversation, std::span<const ExchangePhase> plan,
                           std::int64_t period_ns, bool stepped)
    : link_(link),
      conversation_(conversation),
      plan_(plan),
      period_ns_(period_ns),
      stepped_(stepped),
      records_(kRingBytes) {}

std::int64_t ExchangeTick::now_ns() const noexcept {
  return stepped_ ? static_cast<std::int64_t>(tick_ + 1) * period_ns_ : MonotonicClock::now_ns();
}

bool ExchangeTick::operator()(const loop::TickTiming&) noexcept {
  if (!advance()) return false;
  Record record;
  record.tick = tick_;
  record.phase = phase_;
  record.now_ns = now_ns();
  receive(record);
  if (plan_[phase_].send) send(plan_[phase_], record);
  (void)records_.try_push(0, std::span(&record, 1));  // the ring counts a record that does not fit
  counters_ = link_.counters();
  ++tick_;
  return true;
}

// False at the end of the plan.
bool ExchangeTick::advance() noexcept {
  const std::uint32_t asked = asked_phase_.load(std::memory_order_relaxed);
  const std::uint32_t before = phase_;
  if (asked > phase_) phase_ = asked;
  while (phase_ < plan_.size() && phase_ == before && plan_[phase_].ticks > 0 &&
         tick_ - phase_began_ >= plan_[phase_].ticks)
    ++phase_;
  if (phase_ != before) phase_began_ = tick_;
  return phase_ < plan_.size();
}

void ExchangeTick::receive(Record& record) noexcept {
  std::array<std::byte, firmware::kMaxFrameSize> buffer;
  const hal::ReceivedFrame frame = link_.receive(buffer);
  record.superseded = frame.superseded;
  record.arrival_ns = stepped_ ? record.now_ns : frame.arrival_ns;
  if (frame.size > 0) {
    const auto bytes = std::span<const std::byte>(buffer).first(std::min(frame.size, buffer.size()));
    const bool whole = conversation_.codec.decode(bytes, conversation_.sample) == firmware::DecodeError::kNone &&
                       firmware::decode_state(bytes, conversation_.state) == firmware::DecodeError::kNone;
    record.got = whole ? Got::kFresh : Got::kCorrupt;
  } else if (!link_.connected()) {
    record.got = Got::kDisconnected;
  }
  record.state = conversation_.state;
  record.position_m = conversation_.sample.device_from_tool.position;
}

void ExchangeTick::send(const ExchangePhase& phase, Record& record) noexcept {
  haptics::DeviceCommand command;
  const bool repeats = phase.harm == Harm::kRepeated;
  command.sequence = repeats ? conversation_.command_sequence : ++conversation_.command_sequence;
  command.wanted = static_cast<haptics::DeviceState>(phase.wanted);
  command.rearm = phase.rearm && tick_ - phase_began_ >= kRearmRises ? 1 : 0;
  command.wrench.force = phase.force_N;
  if (phase.harm == Harm::kNotFinite) command.wrench.force.x = std::numeric_limits<double>::quiet_NaN();
  std::array<std::byte, firmware::kCommandFrameSize> bytes{};
  conversation_.codec.encode(command, bytes);
  if (repeats) bytes = last_command_;
  if (phase.harm == Harm::kNone) last_command_ = bytes;
  if (phase.harm == Harm::kBrokenCrc) bytes[13] ^= std::byte{0x10};
  record.command = static_cast<std::uint32_t>(command.sequence);
  record.sent = link_.send(bytes) ? Sent::kTaken : Sent::kRefused;
  record.sent_ns = now_ns();
}

Result<ExchangeResult> run_exchange(hal::AnyLink& link, Conversation& conversation, const ExchangeSettings& settings,
                                    std::span<const ExchangePhase> plan, const Director& director, bool keep) {
  ExchangeResult result;
  ExchangeTick tick(link, conversation, plan, settings.period_ns, settings.stepped);
  Reader reader(tick, director, keep, result);
  if (const Status status = link.start(); !status.ok()) return status;
  const hal::LinkCounters before = link.counters();
  tick.begin_with(before);
  if (settings.stepped) {
    run_stepped(tick, reader);
  } else if (const Status status = run_on_thread(tick, reader, settings, result); !status.ok()) {
    return status;
  }
  // Counters of the last period: a link with its own thread continues to receive while this thread is joined.
  result.counters = since(tick.counters(), before);
  return result;
}

}  // namespace tactus::hil
