#include "tools/view/tape_index.h"

#include <algorithm>

namespace tactus::view {

std::size_t TapeIndex::keyframe_before(std::uint64_t tick) const noexcept {
  const auto after = std::upper_bound(keyframes.begin(), keyframes.end(), tick,
                                      [](std::uint64_t t, const Keyframe& keyframe) { return t < keyframe.tick; });
  return after == keyframes.begin() ? 0 : static_cast<std::size_t>(after - keyframes.begin()) - 1;
}

Result<TapeIndex> index_of(session::OpenTape& tape, session::RunningSummary* counts) {
  TapeIndex index;
  TapeIndex::Keyframe waiting;  // for the tick that follows
  bool waits = false;
  Fault fault = Fault::kNone;
  const auto take_tick = [&](const loop::TickOutput& out) {
    if (index.ticks++ == 0) index.first_tick = out.tick;
    index.last_tick = std::max(index.last_tick, out.tick);
    waiting.tick = out.tick;
    if (waits) index.keyframes.push_back(waiting);
    waits = false;
    if (out.fault != fault && out.fault != Fault::kNone && index.faults.size() < kMaxFaults)
      index.faults.push_back({out.tick, out.fault});
    fault = out.fault;
  };
  const auto take = [&](const loop::TapeRecord& record) {
    if (record.kind == loop::kTickRecord) {
      const auto tick = session::tick_of(record);
      if (!tick.ok()) return tick.status();
      take_tick(tick.value().out);
      if (counts != nullptr) counts->take(tick.value());
    }
    if (record.kind == loop::kKeyframeRecord) {
      waiting = {.tick = 0, .offset = record.offset, .index = record.index};
      waits = true;
    }
    index.has_times = index.has_times || record.kind == loop::kTimesRecord;
    index.gaps += record.kind == loop::kTapeGap ? 1 : 0;
    return Status::good();
  };
  const auto damaged = [&](const std::string& what, std::uint64_t) {
    if (index.damages++ == 0) index.damage = what;
    waits = false;
  };
  if (const Status status = session::walk(tape, {.record = take, .damage = damaged, .progress = {}}); !status.ok())
    return status;
  if (index.keyframes.empty())
    return Status::error(index.damages != 0 ? index.damage : tape.path + ": no tick on it that can be shown");
  return index;
}

}  // namespace tactus::view
