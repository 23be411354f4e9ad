// The exchange of rt/haptics/coupling/exchange.h on two double buffers with a small payload: one thread adopts G(n) and
// answers H(n), the other takes H(n) and sends G(n+1), each with random delays. Run under ThreadSanitizer: the orders
// as they are must be clean, any of the four weakened must be a race.
#include <array>
#include <atomic>
#include <cstring>

#include "rt/base/double_buffer.h"
#include "tests/tsan/race_test.h"

namespace {

using tactus::DoubleBuffer;
using tactus::test::Delays;
using tactus::test::require;

constexpr std::uint64_t kCycles = 200'000;
constexpr std::memory_order kWeak = std::memory_order_relaxed;
constexpr std::memory_order kRelease = std::memory_order_release, kAcquire = std::memory_order_acquire;

using Payload = std::array<std::uint64_t, 16>;

// Every word depends on the cycle and its place, so that no mixture of two values passes.
std::uint64_t word(std::uint64_t n, std::size_t i) { return (n + 1) * 0x9e3779b97f4a7c15ull + i; }

void fill(Payload& payload, std::uint64_t n) {
  for (std::size_t i = 0; i < payload.size(); ++i) payload[i] = word(n, i);
}
void check(const Payload& payload, std::uint64_t n) {
  for (std::size_t i = 0; i < payload.size(); ++i) require(payload[i] == word(n, i), "value torn or old", n);
}

template <class Buffer>
const Payload& await(const Buffer& buffer, std::uint64_t n, Delays& delays) {
  for (;;) {
    if (const Payload* value = buffer.try_read(n)) return *value;
    if (delays.random() % 4 == 0) std::this_thread::yield();
  }
}

template <class Down, class Up>
void exchange() {
  Down down;  // G
  Up up;      // H
  fill(down.writing(0), 0);
  down.publish(0);  // G(0) is there before the first tick

  std::thread haptic([&] {
    Delays delays(1);
    for (std::uint64_t n = 0; n < kCycles; ++n) {
      const Payload& snapshot = await(down, n, delays);
      delays.maybe_wait();
      fill(up.writing(n), n + 1'000'000'007);
      delays.maybe_wait();
      up.publish(n);  // done with G(n-1) before this; G(n) is still read after it
      check(snapshot, n);
      delays.maybe_wait();
      check(snapshot, n);
    }
  });
  std::thread world([&] {
    Delays delays(2);
    for (std::uint64_t n = 0; n < kCycles; ++n) {
      const Payload& report = await(up, n, delays);
      delays.maybe_wait();
      check(report, n + 1'000'000'007);
      fill(down.writing(n + 1), n + 1);
      delays.maybe_wait();
      down.publish(n + 1);
    }
  });
  haptic.join();
  world.join();
  std::puts("all values arrived whole");
}

template <std::memory_order kPublish, std::memory_order kRead>
using Buffer = DoubleBuffer<Payload, kPublish, kRead>;
using Ordered = Buffer<kRelease, kAcquire>;

}  // namespace

int main(int argc, char** argv) {
  const char* variant = argc > 1 ? argv[1] : "ordered";
  if (std::strcmp(variant, "ordered") == 0) {
    exchange<Ordered, Ordered>();
  } else if (std::strcmp(variant, "weak-publish-down") == 0) {
    exchange<Buffer<kWeak, kAcquire>, Ordered>();
  } else if (std::strcmp(variant, "weak-read-down") == 0) {
    exchange<Buffer<kRelease, kWeak>, Ordered>();
  } else if (std::strcmp(variant, "weak-publish-up") == 0) {
    exchange<Ordered, Buffer<kWeak, kAcquire>>();
  } else if (std::strcmp(variant, "weak-read-up") == 0) {
    exchange<Ordered, Buffer<kRelease, kWeak>>();
  } else {
    std::printf("no variant '%s'\n", variant);
    return 2;
  }
  return 0;
}
