#include "rt/base/ring.h"

#include <catch2/catch.hpp>
#include <deque>
#include <random>
#include <vector>

#include "tests/support/rt_guard.h"

using namespace tactus;

namespace {

std::vector<std::byte> random_bytes(std::mt19937& random, std::size_t size) {
  std::vector<std::byte> bytes(size);
  for (auto& b : bytes) b = static_cast<std::byte>(random());
  return bytes;
}

}  // namespace

TEST_CASE("a ring behaves as a queue of records that refuses what does not fit, at every place of the wrap", "[base]") {
  struct Record {
    std::uint32_t kind;
    std::vector<std::byte> payload;
    std::uint64_t lost_before;
  };
  for (const std::uint64_t capacity : {64u, 256u, 1024u}) {
    std::mt19937 random(static_cast<std::uint32_t>(capacity));
    Ring ring(capacity);
    std::deque<Record> model;
    std::uint64_t used = 0, dropped = 0, lost = 0;
    std::vector<std::byte> out(capacity);
    const auto cost = [](std::size_t size) { return 16 + (size + 15) / 16 * 16; };
    for (std::uint32_t step = 0; step < 20'000; ++step) {
      if (random() % 2 == 0) {
        const auto payload = random_bytes(random, random() % (random() % 8 == 0 ? 2 * capacity : capacity / 3));
        const bool fits = used + cost(payload.size()) <= capacity;
        const std::size_t cut = payload.empty() ? 0 : random() % payload.size();
        REQUIRE(ring.try_push(step, std::span(payload).first(cut), std::span(payload).subspan(cut)) == fits);
        if (fits) {
          model.push_back({step, payload, lost});
          used += cost(payload.size());
          lost = 0;
        } else {
          ++dropped;
          ++lost;
        }
      } else {
        RingRecord record;
        const Pop pop = ring.try_pop(record, out);
        REQUIRE((pop == Pop::kEmpty) == model.empty());
        if (pop == Pop::kEmpty) continue;
        REQUIRE(record.kind == model.front().kind);
        REQUIRE(record.size == model.front().payload.size());
        REQUIRE(record.lost_before == model.front().lost_before);
        REQUIRE(std::equal(model.front().payload.begin(), model.front().payload.end(), out.begin()));
        used -= cost(record.size);
        model.pop_front();
      }
      REQUIRE(ring.dropped() == dropped);
    }
    CHECK(dropped > 0);
  }
}

TEST_CASE("a record that was begun but not committed is not there, and its room is free again", "[base]") {
  Ring ring(64);
  std::array<std::byte, 48> payload{};
  payload[0] = std::byte{1};
  REQUIRE(ring.try_begin(1, 48));
  ring.append(std::span(payload).first(20));
  RingRecord record;
  std::array<std::byte, 64> out{};
  CHECK(ring.try_pop(record, out) == Pop::kEmpty);
  REQUIRE(ring.try_push(2, payload));
  CHECK(ring.try_pop(record, out) == Pop::kRecord);
  CHECK(record.kind == 2);
  CHECK(record.size == 48);
  CHECK(record.lost_before == 0);
  CHECK(out[0] == std::byte{1});
  CHECK(ring.try_pop(record, out) == Pop::kEmpty);
}

TEST_CASE("a record larger than the consumer's span is skipped, and its size is returned", "[base]") {
  Ring ring(256);
  const std::array<std::byte, 40> large{};
  const std::array<std::byte, 3> small{std::byte{7}};
  REQUIRE(ring.try_push(1, large));
  REQUIRE(ring.try_push(2, small));
  RingRecord record;
  std::array<std::byte, 16> out{};
  CHECK(ring.try_pop(record, out) == Pop::kTooLarge);
  CHECK(record.size == 40);
  CHECK(ring.try_pop(record, out) == Pop::kRecord);
  CHECK(record.kind == 2);
  CHECK(out[0] == std::byte{7});
}

TEST_CASE("pushing, dropping and popping neither allocate nor lock nor fault", "[base]") {
  Ring ring(4096);
  const std::array<double, 12> payload{};
  std::array<std::byte, 4096> out{};
  RingRecord record;
  std::uint64_t pushed = 0;
  const test::RtGuard guard;
  for (int i = 0; i < 10'000; ++i) {
    pushed += ring.try_push(1, payload) ? 1u : 0u;
    if (i % 3 == 0) (void)ring.try_pop(record, out);
  }
  const auto allocations = guard.allocations(), frees = guard.frees(), locks = guard.locks();
  CHECK(allocations == 0);
  CHECK(frees == 0);
  CHECK(locks == 0);
  CHECK(pushed > 0);
  CHECK(ring.dropped() > 0);
}
