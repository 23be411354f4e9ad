#include "tools/hil/analysis.h"

#include <algorithm>

#include "firmware/faults.h"

namespace tactus::hil {

using firmware::is_newer;
using firmware::Limit;
using firmware::State;

void FrameCounts::add(const Record& record) noexcept {
  ++ticks;
  superseded += record.superseded;
  if (record.sent != Sent::kNotTried) ++commands;
  if (record.sent == Sent::kRefused) ++refused;
  bool is_new = false;
  if (record.got == Got::kFresh) {
    const std::uint32_t sequence = record.state.sequence;
    if (!seen_) {
      superseded_before_first_ = superseded;
      numbered = 1;
      seen_ = is_new = true;
      newest_ = sequence;
      newest_echo_ = record.state.echoed_sequence;
    } else if (is_newer(sequence, newest_)) {
      numbered += sequence - newest_;
      newest_ = sequence;
      is_new = true;
    } else {
      ++(sequence == newest_ ? duplicated : reordered);
    }
    if (is_newer(record.state.echoed_sequence, newest_echo_)) {
      ++answered;
      newest_echo_ = record.state.echoed_sequence;
    }
    ++fresh;
  }
  if (record.got == Got::kCorrupt) ++corrupt;
  if (record.got == Got::kNothing) ++missing_ticks;
  if (record.got == Got::kDisconnected) ++disconnected_ticks;
  gap_ = is_new || !seen_ ? 0 : gap_ + 1;
  longest_gap_ticks = std::max(longest_gap_ticks, gap_);
}

std::uint64_t FrameCounts::lost() const noexcept {
  const std::uint64_t came = fresh - reordered - duplicated + (superseded - superseded_before_first_) + corrupt;
  return numbered > came ? numbered - came : 0;
}

std::uint64_t FrameCounts::unaccounted(const hal::LinkCounters& link) const noexcept {
  const std::uint64_t accounted = fresh + corrupt + superseded;
  return link.received > accounted ? link.received - accounted : accounted - link.received;
}

void RoundTrip::add(const Record& record) noexcept {
  if (record.got == Got::kFresh) {
    const std::uint32_t echo = record.state.echoed_sequence;
    if (seen_ && is_newer(echo, newest_echo_)) {
      const Command& command = commands_[echo % kUnderWay];
      if (command.sequence == echo && command.sent_ns > 0) {
        round_trip.record(record.arrival_ns - command.sent_ns);
        const std::uint64_t acts_us = record.state.time_us;
        if (acts_us >= command.sample_us)
          force_age.record(static_cast<std::int64_t>(acts_us - command.sample_us) * 1000);
      }
    }
    newest_echo_ = echo;
    seen_ = true;
  }
  if (record.sent == Sent::kTaken)
    commands_[record.command % kUnderWay] = {
        .sequence = record.command, .sent_ns = record.sent_ns, .sample_us = record.state.time_us};
}

std::optional<ClockFigures> clock_figures(std::span<const Record> records) {
  std::vector<const Record*> fresh;
  for (const Record& record : records)
    if (record.got == Got::kFresh && (fresh.empty() || is_newer(record.state.sequence, fresh.back()->state.sequence)))
      fresh.push_back(&record);
  const std::size_t tenth = fresh.size() / 10;
  if (tenth < 10) return std::nullopt;
  const auto delay_ns = [&](const Record& r) {
    return static_cast<double>(r.arrival_ns - records.front().now_ns) -
           1e3 * static_cast<double>(static_cast<std::int64_t>(r.state.time_us - fresh.front()->state.time_us));
  };
  const auto shortest = [&](std::size_t from) {
    return *std::min_element(fresh.begin() + static_cast<std::ptrdiff_t>(from),
                             fresh.begin() + static_cast<std::ptrdiff_t>(from + tenth),
                             [&](const Record* a, const Record* b) { return delay_ns(*a) < delay_ns(*b); });
  };
  const Record &first = *shortest(0), &last = *shortest(fresh.size() - tenth);
  const auto device_us = static_cast<double>(last.state.time_us - first.state.time_us);
  const auto host_us = static_cast<double>(last.arrival_ns - first.arrival_ns) * 1e-3;
  const auto frames = static_cast<double>(last.state.sequence - first.state.sequence);
  if (!(frames > 0) || !(host_us > 0) || last.state.time_us <= first.state.time_us) return std::nullopt;
  return ClockFigures{(device_us / host_us - 1) * 1e6, device_us / frames, host_us / frames};
}

WatchdogFigures watchdog_figures(std::span<const Record> records) {
  WatchdogFigures figures;
  const auto note = [](Onset& onset, std::uint32_t missed, bool happened) {
    if (happened) {
      if (!onset.at || missed < *onset.at) onset.at = missed;
    } else if (!onset.after || missed > *onset.after) {
      onset.after = missed;
    }
  };
  bool forced = false;
  for (const Record& record : records) {
    if (record.got != Got::kFresh) continue;
    const firmware::StateFrame& frame = record.state;
    forced = forced || frame.state == State::kForce;
    if (!forced || figures.brake.at) continue;
    const bool brakes = frame.state == State::kBrake;
    if (!brakes) note(figures.fade, frame.missed_commands, (frame.limits & bit_of(Limit::kFading)) != 0);
    note(figures.brake, frame.missed_commands, brakes);
  }
  return figures;
}

std::optional<std::uint32_t> frames_to_brake(std::span<const Record> records, std::size_t first_sign) {
  std::optional<std::uint32_t> clean;
  for (std::size_t i = 0; i < records.size(); ++i) {
    if (records[i].got != Got::kFresh) continue;
    const firmware::StateFrame& frame = records[i].state;
    if (i < first_sign) clean = frame.sequence;
    if (i >= first_sign && clean && frame.state == State::kBrake) return frame.sequence - *clean;
  }
  return std::nullopt;
}

}  // namespace tactus::hil
