#include "rt/loop/flight_recorder.h"

#include <algorithm>

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
  if (watchers_ != nullptr && watchers_->load(std::memory_order_relaxed) != 0) record_bodies(loop);
}

void FlightRecorder::record_bodies(const HapticLoop& loop) noexcept {
  if (until_bodies_ > 0) {
    --until_bodies_;
    return;
  }
  until_bodies_ = kBodiesTicks - 1;
  const auto bodies = loop.sub_world().world().bodies();
  const auto packed = [](double component) noexcept {
    return static_cast<std::int16_t>(std::clamp(32767.0 * component, -32767.0, 32767.0));
  };
  ByteWriter bytes(scratch_.span());
  bytes.put(BodiesRecord{loop.ticks(), static_cast<std::uint32_t>(bodies.size()), loop.sub_world().epoch()});
  for (const physics::Body& body : bodies) {
    const Vec3d& p = body.motion.pose.position;
    const Quatd& q = body.motion.pose.rotation;
    bytes.put(BodyPose{body.id,
                       {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)},
                       {packed(q.w), packed(q.x), packed(q.y), packed(q.z)}});
  }
  TACTUS_CHECK(bytes.ok(), bytes.size(), scratch_.size());
  if (!ring_.try_push(kBodiesRecord, scratch_.span().first(bytes.size()))) until_keyframe_ = 0;
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
                          .member_budget = in.snapshot != nullptr ? in.sink.report->member_budget : 0u,
                          .out = out};
  if (!ring_.try_push(kTickRecord, std::span<const TickRecord, 1>(&record, 1))) until_keyframe_ = 0;
}

void FlightRecorder::times(const TickTimesRecord& times) noexcept {
  if (!ring_.try_push(kTimesRecord, std::span<const TickTimesRecord, 1>(&times, 1))) until_keyframe_ = 0;
}

}  // namespace tactus::loop
