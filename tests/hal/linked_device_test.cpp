#include "hal/linked_device.h"

#include <catch2/catch.hpp>
#include <utility>
#include <vector>

#include "tests/support/rt_guard.h"
#include "tests/support/skip.h"

using namespace tactus;
using namespace tactus::hal;
using haptics::DeviceInput;
using haptics::ReadStatus;

namespace {

constexpr std::int64_t kPeriod_ns = 1'000'000;

// A link that a test fills by hand.
struct TestLink {
  ReceivedFrame next;
  std::array<std::byte, firmware::kMaxFrameSize> bytes{}, sent{};
  std::size_t sent_size{0};
  bool plugged{true}, takes{true};

  ReceivedFrame receive(std::span<std::byte, firmware::kMaxFrameSize> buffer) noexcept {
    std::copy_n(bytes.begin(), std::min(next.size, bytes.size()), buffer.begin());
    return std::exchange(next, {});
  }
  bool send(std::span<const std::byte> frame) noexcept {
    std::copy(frame.begin(), frame.end(), sent.begin());
    sent_size = frame.size();
    return takes;
  }
  bool connected() const noexcept { return plugged; }
  LinkCounters counters() const noexcept { return {}; }
  Result<firmware::ServiceMessage> call(const firmware::ServiceMessage& request, std::chrono::milliseconds) {
    return request;
  }

  void arrives(const firmware::StateFrame& frame, std::int64_t arrival_ns, std::uint32_t superseded = 0) {
    firmware::encode_state(frame, std::span(bytes).first<firmware::kStateFrameSize>());
    next = {firmware::kStateFrameSize, arrival_ns, superseded};
  }
};

using Device = LinkedDevice<TestLink>;
static_assert(haptics::HapticDevice<Device>);

firmware::StateFrame state(std::uint32_t sequence) {
  firmware::StateFrame frame;
  frame.state = firmware::State::kIdle;
  frame.sequence = sequence;
  frame.time_us = 1000ull * sequence;
  return frame;
}

}  // namespace

TEST_CASE("a whole frame is fresh, none is missing, a broken one is corrupt, and a link without device disconnected") {
  TestLink link;
  Device device(*find_profile("virtuose6d"), kPeriod_ns, link);
  DeviceInput input;
  device.read(input);
  CHECK(input.status == ReadStatus::kMissing);
  CHECK(device.newest_arrival_ns() == 0);
  link.arrives(state(7), 123'456, 3);
  device.read(input);
  CHECK(input.status == ReadStatus::kFresh);
  CHECK((input.sample.sequence == 7 && input.sample.device_time_ns == 7'000'000));
  CHECK(device.newest_arrival_ns() == 123'456);
  link.arrives(state(8), 200'000);
  link.bytes[20] ^= std::byte{4};
  device.read(input);
  CHECK(input.status == ReadStatus::kCorrupt);
  CHECK(device.last_decode_error() == firmware::DecodeError::kWrongCrc);
  CHECK((input.sample.sequence == 7 && device.newest_arrival_ns() == 123'456));  // the last one that came
  link.arrives(state(9), 300'000);
  link.plugged = false;
  device.read(input);
  CHECK(input.status == ReadStatus::kDisconnected);
  CHECK(input.sample.sequence == 7);
  const LinkedDeviceCounters& c = device.counters();
  CHECK((c.fresh == 1 && c.missing == 1 && c.corrupt == 1 && c.disconnected == 1 && c.superseded == 3));
}

TEST_CASE("a frame of any wrong length is corrupt, also one longer than the buffer") {
  TestLink link;
  Device device(*find_profile("desk3d"), kPeriod_ns, link);
  DeviceInput input;
  for (std::size_t size = 1; size < 200; ++size) {
    link.arrives(state(static_cast<std::uint32_t>(size)), 1);
    link.next.size = size;
    device.read(input);
    CHECK((input.status == ReadStatus::kFresh) == (size == firmware::kStateFrameSize));
  }
  CHECK(device.counters().corrupt == 198);
}

TEST_CASE("a command goes out as one command frame, and one that the link refuses is counted") {
  TestLink link;
  Device device(*find_profile("virtuose6d"), kPeriod_ns, link);
  device.write({41, {}, haptics::DeviceState::kForce, 0});
  firmware::CommandFrame frame;
  REQUIRE(link.sent_size == firmware::kCommandFrameSize);
  REQUIRE(firmware::decode_command(std::span(link.sent).first(link.sent_size), frame) == firmware::DecodeError::kNone);
  CHECK((frame.sequence == 41 && frame.wanted == firmware::State::kForce));
  CHECK(device.counters().not_sent == 0);
  link.takes = false;
  device.write({42, {}, haptics::DeviceState::kForce, 0});
  CHECK(device.counters().not_sent == 1);
}

TEST_CASE("a device on a link has its profile's properties and the delay of its ticks at its period") {
  TestLink link;
  for (const DeviceProfile& profile : all_profiles()) {
    const Device device(profile, 250'000, link);
    CHECK(device.properties().max_force_N == profile.properties.max_force_N);
    CHECK(device.properties().delay_s == Approx(250e-6 * profile.transport_delay_ticks));
  }
}

TEST_CASE("a device on a link neither allocates nor locks", "[no-asan][no-tsan]") {
  TestLink link;
  Device device(*find_profile("virtuose6d"), kPeriod_ns, link);
  DeviceInput input;
  TACTUS_NEEDS(test::RtGuard::available(), "counting allocations needs a build without a sanitizer");
  const test::RtGuard guard;
  for (std::uint32_t i = 1; i < 1000; ++i) {
    link.arrives(state(i), i);
    device.read(input);
    device.write({i, {{1, 2, 3}, {}}, haptics::DeviceState::kForce, 0});
    device.read(input);
  }
  CHECK(guard.allocations() == 0);
  CHECK(guard.frees() == 0);
  CHECK(guard.locks() == 0);
  CHECK(device.counters().fresh == 999);
}
