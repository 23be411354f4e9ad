// One producer and one consumer on a small ring, so that it is full and empty all the time and wraps at every place.
// Run under ThreadSanitizer: the orders as they are must be clean, each of the two weakened must be a race.
#include <array>
#include <atomic>
#include <cstring>

#include "rt/base/ring.h"
#include "tests/tsan/race_test.h"

namespace {

using tactus::BasicRing;
using tactus::Pop;
using tactus::RingRecord;
using tactus::test::Delays;
using tactus::test::require;

constexpr std::uint32_t kRecords = 150'000;
constexpr std::uint32_t kMaxPayload = 200;

std::byte byte_of(std::uint32_t number, std::uint32_t i) {
  return static_cast<std::byte>((number * 31 + i * 7) & 0xff);
}
std::uint32_t size_of(std::uint32_t number) { return number * 2654435761u >> 16 & 0xff; }

template <class Ring>
void produce(Ring& ring, std::atomic<bool>& done) {
  Delays delays(3);
  std::array<std::byte, 256> payload{};
  for (std::uint32_t number = 0; number < kRecords; ++number) {
    const std::uint32_t size = size_of(number) % kMaxPayload;
    for (std::uint32_t i = 0; i < size; ++i) payload[i] = byte_of(number, i);
    const std::span bytes(payload);
    // Either way of writing: at once from two pieces, or begun and ended with a delay between.
    if (number % 2 == 0) {
      if (!ring.try_push(number, bytes.first(size / 3), bytes.subspan(size / 3, size - size / 3))) {
        std::this_thread::yield();  // full: the next may fit
      }
    } else if (ring.try_begin(number, size)) {
      ring.append(bytes.first(size));
      delays.maybe_wait();
      ring.commit();
    }
    delays.maybe_wait();
  }
  done.store(true, std::memory_order_relaxed);
}

template <class Ring>
void consume(Ring& ring, const std::atomic<bool>& done) {
  Delays delays(4);
  std::array<std::byte, 256> payload{};
  std::uint64_t next = 0, records = 0, lost = 0;
  for (;;) {
    const bool last_round = done.load(std::memory_order_relaxed);
    RingRecord record;
    const Pop pop = ring.try_pop(record, payload);
    if (pop == Pop::kEmpty) {
      // `done` orders nothing, so what was pushed may still be under way: the counts say when it is here.
      if (last_round && records + ring.dropped() == kRecords) break;
      std::this_thread::yield();
      continue;
    }
    require(pop == Pop::kRecord, "payload fits", record.size);
    lost += record.lost_before;
    next += record.lost_before;
    require(record.kind == next, "records in order, gaps told", next);
    const auto number = static_cast<std::uint32_t>(next);
    require(record.size == size_of(number) % kMaxPayload, "size", next);
    for (std::uint32_t i = 0; i < record.size; ++i) require(payload[i] == byte_of(number, i), "payload torn", next);
    ++next;
    ++records;
    delays.maybe_wait();
  }
  require(lost <= ring.dropped(), "gaps told are drops", lost);
  std::printf("%llu records came, %llu were dropped\n", static_cast<unsigned long long>(records),
              static_cast<unsigned long long>(ring.dropped()));
  std::puts("all values arrived whole");
}

template <class Ring>
void exchange() {
  Ring ring(1024);
  std::atomic<bool> done{false};
  std::thread producer([&] { produce(ring, done); });
  std::thread consumer([&] { consume(ring, done); });
  producer.join();
  consumer.join();
}

}  // namespace

int main(int argc, char** argv) {
  constexpr std::memory_order kWeak = std::memory_order_relaxed;
  const char* variant = argc > 1 ? argv[1] : "ordered";
  if (std::strcmp(variant, "ordered") == 0) {
    exchange<tactus::Ring>();
  } else if (std::strcmp(variant, "weak-release") == 0) {
    exchange<BasicRing<kWeak, std::memory_order_acquire>>();
  } else if (std::strcmp(variant, "weak-acquire") == 0) {
    exchange<BasicRing<std::memory_order_release, kWeak>>();
  } else {
    std::printf("no variant '%s'\n", variant);
    return 2;
  }
  return 0;
}
