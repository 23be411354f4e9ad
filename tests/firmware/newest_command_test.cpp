// Of the commands that come in one period: which counts.
#include <algorithm>
#include <cmath>
#include <deque>
#include <vector>

#include "firmware/board.h"
#include "tests/firmware/device_bench.h"

using namespace tactus::firmware;

TEST_CASE("of the commands of one period the newest by sequence acts, whatever comes after it") {
  struct QueueLink {
    StateFrame state;
    std::deque<std::vector<std::byte>> queue;
    std::size_t receive_command(std::span<std::byte, kMaxFrameSize> buffer) noexcept {
      if (queue.empty()) return 0;
      const std::vector<std::byte> frame = queue.front();
      queue.pop_front();
      std::copy(frame.begin(), frame.end(), buffer.begin());
      return frame.size();
    }
    void command(std::uint32_t sequence, float effort, State wanted = State::kForce) {
      std::vector<std::byte> frame(kCommandFrameSize);
      encode_command({wanted, false, sequence, {effort, 0, 0, 0, 0, 0}}, std::span(frame).first<kCommandFrameSize>());
      queue.push_back(std::move(frame));
    }
    void send_state(std::span<const std::byte> frame) noexcept { static_cast<void>(decode_state(frame, state)); }
    bool receive_service(ServiceMessage&) noexcept { return false; }
    void reply_service(const ServiceMessage&) noexcept {}
  };
  struct FakeMechanics {
    std::uint64_t time_us{0};
    ControllerOutputs driven;
    void sample(ControllerInputs& inputs) noexcept { inputs.time_us = time_us += 1000; }
    void drive(const ControllerOutputs& outputs) noexcept { driven = outputs; }
  };
  Device device(bench_config());
  FakeMechanics mechanics;
  QueueLink link;
  const auto start = GENERATE(7u, 0xfffffff0u);
  for (std::uint32_t i = 0; i < 12; ++i) {
    link.command(start + i, 1.0f, i == 0 ? State::kIdle : State::kForce);
    run_period(device, mechanics, link);
  }
  REQUIRE(device.controller().state() == State::kForce);
  for (std::uint32_t i = 12; i < 40; ++i) {
    const auto effort = static_cast<float>(i) * 0.1f;
    const std::uint32_t refused = device.controller().refused_frames();
    link.command(start + i, effort);
    link.command(start + i - 5 - i % 6, -9.0f);  // old
    link.command(start + i, -9.0f);              // repeated
    link.queue.push_back(link.queue.front());
    link.queue.back()[14] ^= std::byte{4};  // broken
    link.queue.push_back({std::byte{0x74}});
    run_period(device, mechanics, link);
    CAPTURE(i);
    CHECK(link.state.echoed_sequence == start + i);
    CHECK(link.state.missed_commands == 0);
    CHECK(mechanics.driven.effort[0] == effort);
    CHECK(device.controller().refused_frames() == refused + 4);
    CHECK(link.queue.empty());
  }
  // Two good ones out of order: the newer counts.
  link.command(start + 42, 2.0f);
  link.command(start + 41, 3.0f);
  run_period(device, mechanics, link);
  CHECK(link.state.echoed_sequence == start + 42);
  CHECK(mechanics.driven.effort[0] == 2.0f);
}

TEST_CASE("a stale command that is not finite is refused without fault, one that is not stale is a fault") {
  DeviceBench b;
  b.start_force({1});
  for (int i = 0; i < 20; ++i) {
    std::array<std::byte, kCommandFrameSize> stale{};
    encode_command({State::kForce, false, b.sequence - static_cast<std::uint32_t>(i % 2), {NAN}}, stale);
    b.device.hear(stale);
    b.command(State::kForce, {1});
    REQUIRE(b.state() == State::kForce);
    REQUIRE(b.outputs.effort[0] == 1.0f);
  }
  CHECK(b.device.controller().refused_frames() == 20);
  // Also where a good one follows in the same period.
  std::array<std::byte, kCommandFrameSize> fresh{};
  encode_command({State::kForce, false, ++b.sequence, {NAN}}, fresh);
  b.device.hear(fresh);
  b.command(State::kForce, {1});
  CHECK(b.fault() == Fault::kEffortNotFinite);
}
