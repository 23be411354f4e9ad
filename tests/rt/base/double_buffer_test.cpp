#include "rt/base/double_buffer.h"

#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <thread>

using namespace tactus;

namespace {

using Payload = std::array<std::uint64_t, 8>;

Payload payload_of(std::uint64_t n) {
  Payload payload{};
  for (std::size_t i = 0; i < payload.size(); ++i) payload[i] = n * 0x9e3779b97f4a7c15ull + i;
  return payload;
}

}  // namespace

TEST_CASE("a value is there from its publication on, not before", "[base]") {
  DoubleBuffer<Payload> buffer;
  CHECK(buffer.try_read(0) == nullptr);
  buffer.writing(0) = payload_of(0);
  CHECK(buffer.try_read(0) == nullptr);
  buffer.publish(0);
  REQUIRE(buffer.try_read(0) != nullptr);
  CHECK(*buffer.try_read(0) == payload_of(0));
  CHECK(buffer.try_read(1) == nullptr);
}

TEST_CASE("the newest two values are there together, and writing one leaves the other alone", "[base]") {
  DoubleBuffer<Payload> buffer;
  for (std::uint64_t n = 0; n < 100; ++n) {
    buffer.writing(n) = payload_of(n);
    if (n > 0) CHECK(*buffer.try_read(n - 1) == payload_of(n - 1));
    buffer.publish(n);
    CHECK(*buffer.try_read(n) == payload_of(n));
    if (n > 0) CHECK(*buffer.try_read(n - 1) == payload_of(n - 1));
  }
}

TEST_CASE("a value begins as zeros: nothing uninitialised crosses a thread", "[base]") {
  DoubleBuffer<Payload> buffer;
  CHECK(buffer.writing(0) == Payload{});
  CHECK(buffer.writing(1) == Payload{});
}

// The memory orders are proven by tests/tsan/double_buffer_race.cpp; this runs the protocol in every build.
TEST_CASE("two threads that follow the protocol of the exchange read no torn value", "[base][threads]") {
  constexpr std::uint64_t kCycles = 20'000;
  DoubleBuffer<Payload> down, up;
  down.writing(0) = payload_of(0);
  down.publish(0);
  std::atomic<std::uint64_t> wrong{0};
  const auto await = [](const DoubleBuffer<Payload>& buffer, std::uint64_t n) -> const Payload& {
    for (;;) {
      if (const Payload* value = buffer.try_read(n)) return *value;
      std::this_thread::yield();
    }
  };
  std::thread world([&] {
    for (std::uint64_t n = 0; n < kCycles; ++n) {
      if (await(up, n) != payload_of(n + 7)) ++wrong;
      down.writing(n + 1) = payload_of(n + 1);
      down.publish(n + 1);
    }
  });
  for (std::uint64_t n = 0; n < kCycles; ++n) {
    const Payload& snapshot = await(down, n);
    up.writing(n) = payload_of(n + 7);
    up.publish(n);
    if (snapshot != payload_of(n)) ++wrong;
  }
  world.join();
  CHECK(wrong == 0);
}
