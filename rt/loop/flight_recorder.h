// Records on the haptic thread what a replay needs: every tick's input and output, every adopted snapshot, and periodic
// keyframes.
//
// Records go through a byte ring to a normal thread, which keeps the last seconds and, on request, writes the tape.
// Thread: construction [setup]; before_tick, after_tick [rt]; ring() consumer: a normal thread. Bound: a record that
// does not fit is dropped and counted, without waiting; a tape with a gap replays from the next keyframe.
#pragma once

#include <atomic>

#include "rt/base/ring.h"
#include "rt/loop/haptic_loop.h"

namespace tactus::loop {

// Explicit numbers, never reused: they are on tapes.
enum RecordKind : std::uint32_t {
  kKeyframeRecord = 1,  // HapticLoop::save before a tick
  kSnapshotRecord = 2,  // haptics::write_snapshot; adopted by the tick record that follows
  kTickRecord = 3,      // TickRecord
  kTimesRecord = 4,     // TickTimesRecord, of the tick record before it; measured, so a replay ignores it
  kBodiesRecord = 5,    // BodiesRecord, then a BodyPose per body: for display only, never on a tape
};

struct TickRecord {
  haptics::DeviceInput device;
  std::uint32_t operator_bits{0};
  std::uint32_t sub_steps{0};
  std::uint32_t adopts{0};  // 1: the snapshot before this record is adopted in this tick
  // Of an adopting tick: the governor's members for the next cycle, as in the report; 0: not recorded. Replay ignores
  // it.
  std::uint32_t member_budget{0};
  TickOutput out;
};
static_assert(std::is_trivially_copyable_v<TickRecord>);

// When a tick took place, and how long its stages took; not recorded in virtual time, which measures nothing.
struct TickTimesRecord {
  std::uint64_t tick{0};
  std::int64_t woke_ns{0};      // CLOCK_MONOTONIC: its beginning
  std::uint32_t wake_ns{0};     // from its scheduled beginning to its beginning
  std::uint32_t read_ns{0};     // the device's sample
  std::uint32_t compute_ns{0};  // HapticLoop::tick, with the exchange and the recorder's keyframes
  std::uint32_t write_ns{0};    // the command to the device, with the recorder's tick record and the lines
};
static_assert(std::is_trivially_copyable_v<TickTimesRecord> && sizeof(TickTimesRecord) == 32);

// The members' poses, for programs that display a run with the direct coupling, which has no global world.
struct BodiesRecord {
  std::uint64_t tick{0};  // ticks done
  std::uint32_t bodies{0};
  std::uint32_t resets{0};  // of the scene, so far
};
struct BodyPose {
  BodyId id{kNoBody};
  float position[3]{};         // m, world
  std::int16_t rotation[4]{};  // w x y z, times 32,767
};
static_assert(sizeof(BodiesRecord) == 16 && sizeof(BodyPose) == 24);
inline constexpr std::uint32_t kBodiesTicks = 16;  // ticks between two records

class FlightRecorder {
 public:
  // A keyframe every `keyframe_ticks`; the ring holds `ring_bytes` (a power of two).
  FlightRecorder(const HapticLoop& loop, std::uint64_t ring_bytes, std::uint32_t keyframe_ticks);

  void before_tick(const HapticLoop& loop) noexcept TACTUS_NONBLOCKING;
  void after_tick(const TickInput& in, const TickOutput& out) noexcept TACTUS_NONBLOCKING;
  void times(const TickTimesRecord& times) noexcept TACTUS_NONBLOCKING;

  // [setup] Records the members' poses every kBodiesTicks ticks while `watchers`, the number of displaying programs, is
  // not 0. `watchers` must outlive the recorder.
  void show_bodies(const std::atomic<std::uint32_t>& watchers) noexcept { watchers_ = &watchers; }

  Ring& ring() noexcept { return ring_; }
  std::uint64_t dropped() const noexcept { return ring_.dropped(); }

 private:
  void record_bodies(const HapticLoop& loop) noexcept;

  Ring ring_;
  BoundedVector<std::byte> scratch_;
  std::uint32_t keyframe_ticks_;
  std::uint32_t until_keyframe_{0};
  const std::atomic<std::uint32_t>* watchers_{nullptr};
  std::uint32_t until_bodies_{0};
};

}  // namespace tactus::loop
