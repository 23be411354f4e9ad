#include "rt/loop/flight_recorder.h"

#include <catch2/catch.hpp>
#include <cstring>
#include <memory>
#include <vector>

#include "rt/haptics/coupling/snapshot_bytes.h"
#include "tests/support/bits.h"
#include "tests/support/rt_guard.h"

using namespace tactus;
using namespace tactus::loop;

namespace {

LoopConfig make_config() {
  LoopConfig config;
  config.sub_world.border_mode = physics::BorderMode::kCapped;
  config.sub_world.ratio = 4;
  config.sub_world.step.dt = config.period_s;
  config.sub_world.capacities = {.bodies = 4, .fixed_bodies = 1, .pairs = 8, .contacts = 4, .border_contacts = 2};
  return config;
}

struct Record {
  RingRecord head;
  std::vector<std::byte> payload;
};

// A loop that adopts a snapshot every fourth tick, and its recorder.
struct Bench {
  Bench(std::uint64_t ring_bytes, std::uint32_t keyframe_ticks)
      : loop(make_config(), {}), recorder(loop, ring_bytes, keyframe_ticks) {
    REQUIRE(snapshot->members.try_push(0));
    REQUIRE(snapshot->joiners.try_push(physics::make_dynamic_body(0, physics::Shape::sphere(0.02), 0.2, 0.5, {})));
    in.sink.report = report.get();
    in.device.sample.state = haptics::DeviceState::kForce;
  }

  std::unique_ptr<haptics::WorldSnapshot> snapshot = std::make_unique<haptics::WorldSnapshot>();
  std::unique_ptr<haptics::SubWorldReport> report = std::make_unique<haptics::SubWorldReport>();
  HapticLoop loop;
  FlightRecorder recorder;
  TickInput in;
  TickOutput out;
  std::uint64_t next_cycle{0};

  void tick() {
    in.device.status = haptics::ReadStatus::kFresh;
    auto& sample = in.device.sample;
    ++sample.sequence;
    sample.device_time_ns += 1'000'000;
    sample.device_from_tool.position.x += 1e-5;
    in.operator_bits = sample.sequence == 3 ? kArm : 0u;
    in.sub_steps = 2 + static_cast<std::uint32_t>(sample.sequence % 3);
    in.snapshot = nullptr;
    if (loop.wants_snapshot()) {
      snapshot->cycle = next_cycle++;
      in.snapshot = snapshot.get();
    }
    recorder.before_tick(loop);
    loop.tick(in, out);
    recorder.after_tick(in, out);
  }

  std::vector<Record> drain() {
    std::vector<Record> records;
    std::vector<std::byte> buffer(recorder.ring().capacity());
    Record record;
    while (recorder.ring().try_pop(record.head, buffer) == Pop::kRecord) {
      record.payload.assign(buffer.begin(), buffer.begin() + record.head.size);
      records.push_back(record);
    }
    return records;
  }
};

TickRecord tick_of(const Record& record) {
  REQUIRE(record.payload.size() == sizeof(TickRecord));
  TickRecord tick;
  std::memcpy(&tick, record.payload.data(), sizeof tick);
  return tick;
}

}  // namespace

TEST_CASE("a tick's records come as keyframe, snapshot, tick, and keyframes at their interval") {
  Bench bench(1u << 20, 6);
  for (int t = 0; t < 24; ++t) bench.tick();
  const auto records = bench.drain();
  std::size_t at = 0;
  for (std::uint64_t t = 0; t < 24; ++t) {
    CAPTURE(t);
    if (t % 6 == 0) {
      REQUIRE(records[at].head.kind == kKeyframeRecord);
      ++at;
    }
    if (t % 4 == 0) {
      REQUIRE(records[at].head.kind == kSnapshotRecord);
      const auto adopted = std::make_unique<haptics::WorldSnapshot>();
      ByteReader in(records[at].payload);
      REQUIRE(haptics::read_snapshot(in, *adopted));
      CHECK(adopted->cycle == t / 4);
      ++at;
    }
    REQUIRE(records[at].head.kind == kTickRecord);
    const TickRecord tick = tick_of(records[at++]);
    CHECK(tick.out.tick == t);
    CHECK(tick.adopts == (t % 4 == 0 ? 1u : 0u));
    CHECK(tick.sub_steps == 2 + (t + 1) % 3);
    CHECK(tick.operator_bits == (t == 2 ? kArm : 0u));
    CHECK(tick.device.sample.sequence == t + 1);
  }
  CHECK(at == records.size());
  CHECK(bench.recorder.dropped() == 0);
}

TEST_CASE("what was recorded replays from any keyframe, byte by byte") {
  Bench bench(1u << 20, 7);
  for (int t = 0; t < 60; ++t) bench.tick();
  const auto records = bench.drain();
  const auto adopted = std::make_unique<haptics::WorldSnapshot>();
  const auto report = std::make_unique<haptics::SubWorldReport>();
  for (std::size_t begin = 0; begin < records.size(); ++begin) {
    if (records[begin].head.kind != kKeyframeRecord) continue;
    HapticLoop loop(make_config(), {});
    ByteReader keyframe(records[begin].payload);
    REQUIRE(loop.restore(keyframe));
    for (std::size_t i = begin + 1; i < records.size(); ++i) {
      ByteReader bytes(records[i].payload);
      if (records[i].head.kind == kSnapshotRecord) REQUIRE(haptics::read_snapshot(bytes, *adopted));
      if (records[i].head.kind != kTickRecord) continue;
      const TickRecord tick = tick_of(records[i]);
      TickInput in;
      in.device = tick.device;
      in.operator_bits = tick.operator_bits;
      in.sub_steps = tick.sub_steps;
      in.snapshot = tick.adopts != 0 ? adopted.get() : nullptr;
      in.sink.report = report.get();
      TickOutput out;
      loop.tick(in, out);
      REQUIRE(test::same_bits(out, tick.out));
    }
  }
}

TEST_CASE("after a lost record a keyframe follows as soon as there is room") {
  Bench bench(1u << 14, 1000);  // one keyframe at the start, and none due for long
  while (bench.recorder.dropped() == 0) bench.tick();
  const std::uint64_t lost_at = bench.out.tick;
  bench.tick();
  bench.tick();  // still no room: nothing waits
  const std::uint64_t dropped = bench.recorder.dropped();
  CHECK(dropped > 1);
  const auto before = bench.drain();
  std::uint64_t lost_before = 0;
  for (const auto& record : before) {
    lost_before += record.head.lost_before;
    if (record.head.kind == kTickRecord) CHECK(tick_of(record).out.tick <= lost_at + 1);
  }

  bench.tick();
  const auto after = bench.drain();
  REQUIRE(after.size() >= 2);
  CHECK(after.front().head.kind == kKeyframeRecord);
  CHECK(lost_before + after.front().head.lost_before == dropped);
  CHECK(tick_of(after.back()).out.tick == bench.out.tick);
  CHECK(bench.recorder.dropped() == dropped);
  // And only one: the interval starts again.
  for (int i = 0; i < 5; ++i) bench.tick();
  for (const auto& record : bench.drain()) CHECK(record.head.kind != kKeyframeRecord);
}

TEST_CASE("recording neither allocates nor locks, nor changes the output of the loop") {
  Bench recorded(1u << 20, 5), full(1u << 10, 5);
  const test::RtGuard guard;
  for (int t = 0; t < 100; ++t) {
    recorded.tick();
    full.tick();
  }
  const auto allocations = guard.allocations(), locks = guard.locks();
  CHECK(allocations == 0);
  CHECK(locks == 0);
  CHECK(full.recorder.dropped() > 0);
  CHECK(test::same_bits(recorded.out, full.out));
  CHECK(recorded.loop.state_hash() == full.loop.state_hash());
}
