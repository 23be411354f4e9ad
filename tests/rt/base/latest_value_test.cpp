#include "rt/base/latest_value.h"

#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <random>
#include <thread>

using namespace tactus;

namespace {

using Payload = std::array<std::uint64_t, 8>;

Payload payload_of(std::uint64_t n) {
  Payload payload{};
  for (std::size_t i = 0; i < payload.size(); ++i) payload[i] = n * 0x9e3779b97f4a7c15ull + i;
  return payload;
}

bool publish(LatestValue<Payload>& exchange, std::uint64_t n) {
  exchange.writing() = payload_of(n);
  return exchange.publish();
}

}  // namespace

TEST_CASE("nothing is there before the first value, and each value is there once", "[base]") {
  LatestValue<Payload> exchange;
  CHECK(exchange.take() == nullptr);
  exchange.writing() = payload_of(1);
  CHECK(exchange.take() == nullptr);
  CHECK_FALSE(exchange.publish());
  const Payload* value = exchange.take();
  REQUIRE(value != nullptr);
  CHECK(*value == payload_of(1));
  CHECK(exchange.take() == nullptr);
  CHECK(*value == payload_of(1));  // until the next that is taken
}

TEST_CASE("of several values the newest is taken, and the others are counted", "[base]") {
  LatestValue<Payload> exchange;
  for (std::uint64_t n = 0; n < 10; ++n) CHECK(publish(exchange, n) == (n > 0));
  CHECK(exchange.superseded() == 9);
  REQUIRE(exchange.take() != nullptr);
  CHECK_FALSE(publish(exchange, 10));
  CHECK(*exchange.take() == payload_of(10));
  CHECK(exchange.superseded() == 9);
}

TEST_CASE("a taken value stays as it is while any number of newer ones are published", "[base]") {
  LatestValue<Payload> exchange;
  publish(exchange, 0);
  const Payload* value = exchange.take();
  REQUIRE(value != nullptr);
  for (std::uint64_t n = 1; n < 100; ++n) {
    publish(exchange, n);
    CHECK(*value == payload_of(0));
  }
}

TEST_CASE("in any order of both sides' calls the newest value is taken, and every value is accounted for", "[base]") {
  std::mt19937_64 random(7);
  for (int round = 0; round < 50; ++round) {
    LatestValue<Payload> exchange;
    std::uint64_t published = 0, taken = 0, newest_taken = 0;
    bool replaces = false;
    for (int step = 0; step < 500; ++step) {
      if (random() % 3 != 0) {
        CHECK(publish(exchange, ++published) == replaces);
        replaces = true;
      } else if (const Payload* value = exchange.take()) {
        CHECK(*value == payload_of(published));
        newest_taken = published;
        ++taken;
        replaces = false;
      } else {
        CHECK(newest_taken == published);
      }
    }
    CHECK(published == taken + exchange.superseded() + (replaces ? 1 : 0));
  }
}

// The memory orders are proven by tests/tsan/latest_value_race.cpp; this runs the protocol in every build.
TEST_CASE("two threads at different rates read values untorn and in order, and all are counted", "[base][threads]") {
  constexpr std::uint64_t kValues = 100'000;
  LatestValue<Payload> exchange;
  std::atomic<bool> done{false};
  std::thread producer([&] {
    for (std::uint64_t n = 1; n <= kValues; ++n) {
      publish(exchange, n);
      if (n % 64 == 0) std::this_thread::yield();
    }
    done.store(true, std::memory_order_release);
  });
  std::uint64_t taken = 0, newest = 0, wrong = 0;
  for (bool last = false; !last;) {
    last = done.load(std::memory_order_acquire);
    while (const Payload* value = exchange.take()) {
      const std::uint64_t n = (*value)[0] * 0xf1de83e19937733dull;  // the multiplier's inverse modulo 2^64
      if (n <= newest || n > kValues || *value != payload_of(n)) ++wrong;
      newest = n;
      ++taken;
    }
    std::this_thread::yield();
  }
  producer.join();
  CHECK(wrong == 0);
  CHECK(newest == kValues);
  CHECK(taken + exchange.superseded() == kValues);
}
