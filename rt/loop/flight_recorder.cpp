#include "rt/loop/flight_recorder.h"

#include "rt/haptics/coupling/snapshot_bytes.h"

namespace tactus::loop {

FlightRecorder::FlightRecorder(const HapticLoop& loop, std::uint64_t ring_bytes, std::uint32_t keyframe_ticks)
    : ring_(ring_bytes),
      scratch_(static_cast<std::uint32_t>(std::max(loop.save_size_bound(), haptics::snapshot_bytes_bound()))),
      keyframe_ticks_(keyframe_ticks) {
  scratch_.resize(scratch_.capacity());
}

void FlightRecorder::before_tick(const HapticLoop& loop) noexcept TACTUS_NONBLOCKING {
  if (until_keyframe_ == 0) {
    ByteWriter bytes(scratch_.span());
    loop.save(bytes);
    TACTUS_CHECK(bytes.ok(), bytes.size(), scratch_.size());
    // Dropped if the ring is full; the next tick retries.
    if (ring_.try_push(kKeyframeRecord, scratch_.span().first(bytes.size()))) until_keyframe_ = keyframe_ticks_;
  }
  if (until_keyframe_ > 0) --until_keyframe_;
}

void FlightRecorder::after_tick(const TickInput& in, const TickOutput& out) noexcept TACTUS_NONBLOCKING {
  if (in.snapshot != nullptr) {
    ByteWriter bytes(scratch_.span());
    haptics::write_snapshot(bytes, *in.snapshot);
    TACTUS_CHECK(bytes.ok(), bytes.size(), scratch_.size());
    if (!ring_.try_push(kSnapshotRecord, scratch_.span().first(bytes.size()))) until_keyframe_ = 0;
  }
  const TickRecord record{.device = in.device,
                          .operator_bits = in.operator_bits,
                          .sub_steps = in.sub_steps,
                          .adopts = in.snapshot != nullptr ? 1u : 0u,
                          .padding = 0,
                          .out = out};
  if (!ring_.try_push(kTickRecord, std::span<const TickRecord, 1>(&record, 1))) until_keyframe_ = 0;
}

}  // namespace tactus::loop
