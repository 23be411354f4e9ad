// Records on the haptic thread what a replay needs: every tick's input and output, every adopted snapshot, and periodic
// keyframes.
//
// Records go through a byte ring to a normal thread, which keeps the last seconds and, on request, writes the tape.
// Thread: construction [setup]; before_tick, after_tick [rt]; ring() consumer: a normal thread. Bound: a record that
// does not fit is dropped and counted, without waiting; a tape with a gap replays from the next keyframe.
#pragma once

#include "rt/base/ring.h"
#include "rt/loop/haptic_loop.h"

namespace tactus::loop {

// Explicit numbers, never reused: they are on tapes.
enum RecordKind : std::uint32_t {
  kKeyframeRecord = 1,  // HapticLoop::save before a tick
  kSnapshotRecord = 2,  // haptics::write_snapshot; adopted by the tick record that follows
  kTickRecord = 3,      // TickRecord
};

struct TickRecord {
  haptics::DeviceInput device;
  std::uint32_t operator_bits{0};
  std::uint32_t sub_steps{0};
  std::uint32_t adopts{0};  // 1: the snapshot before this record is adopted in this tick
  std::uint32_t padding{0};
  TickOutput out;
};
static_assert(std::is_trivially_copyable_v<TickRecord>);

class FlightRecorder {
 public:
  // A keyframe every `keyframe_ticks`; the ring holds `ring_bytes` (a power of two).
  FlightRecorder(const HapticLoop& loop, std::uint64_t ring_bytes, std::uint32_t keyframe_ticks);

  void before_tick(const HapticLoop& loop) noexcept TACTUS_NONBLOCKING;
  void after_tick(const TickInput& in, const TickOutput& out) noexcept TACTUS_NONBLOCKING;

  Ring& ring() noexcept { return ring_; }
  std::uint64_t dropped() const noexcept { return ring_.dropped(); }

 private:
  Ring ring_;
  BoundedVector<std::byte> scratch_;
  std::uint32_t keyframe_ticks_;
  std::uint32_t until_keyframe_{0};
};

}  // namespace tactus::loop
