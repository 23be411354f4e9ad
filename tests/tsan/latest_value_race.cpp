// The exchange of the newest value, one producer and one consumer at rates of their own with random delays. Run under
// ThreadSanitizer: the orders as they are must be clean, any of the four weakened must be a race. The mailbox
// and the command queue of the Linux boards are the same exchange in firmware/'s own words: they run with the ordered
// variant.
#include <array>
#include <atomic>
#include <cstring>

#include "firmware/boards/linux/mailbox.h"
#include "rt/base/latest_value.h"
#include "tests/tsan/race_test.h"

namespace {

using tactus::LatestValue;
using tactus::test::Delays;
using tactus::test::require;

constexpr std::uint64_t kValues = 150'000;

using Payload = std::array<std::uint64_t, 8>;

std::uint64_t word(std::uint64_t n, std::size_t i) { return n * 0x9e3779b97f4a7c15ull + i; }

void fill(Payload& payload, std::uint64_t n) {
  payload[0] = n;
  for (std::size_t i = 1; i < payload.size(); ++i) payload[i] = word(n, i);
}
void check(const Payload& payload, std::uint64_t newest) {
  require(payload[0] > newest && payload[0] <= kValues, "values in order", newest);
  for (std::size_t i = 1; i < payload.size(); ++i) require(payload[i] == word(payload[0], i), "value torn", payload[0]);
}

// `publish(n)` in one thread, `take()` in the other: the number of what it got, 0 for nothing.
template <class Publish, class Take>
void exchange(Publish&& publish, Take&& take) {
  std::thread producer([&] {
    Delays delays(5);
    for (std::uint64_t n = 1; n <= kValues; ++n) {
      publish(n, delays);
      delays.maybe_wait();
    }
  });
  std::thread consumer([&] {
    Delays delays(6);
    for (std::uint64_t newest = 0; newest != kValues;) {
      if (const std::uint64_t n = take(newest, delays)) {
        newest = n;
      } else if (delays.random() % 4 == 0) {
        std::this_thread::yield();
      }
      delays.maybe_wait();
    }
  });
  producer.join();
  consumer.join();
}

template <std::memory_order kPublish, std::memory_order kTake>
void exchange_latest() {
  LatestValue<Payload, kPublish, kTake> latest;
  exchange(
      [&](std::uint64_t n, Delays& delays) {
        fill(latest.writing(), n);
        delays.maybe_wait();
        latest.publish();
      },
      [&](std::uint64_t newest, Delays& delays) -> std::uint64_t {
        const Payload* value = latest.take();
        if (value == nullptr) return 0;
        check(*value, newest);
        delays.maybe_wait();
        check(*value, newest);
        return (*value)[0];
      });
}

void exchange_mailbox() {
  tactus::firmware::Mailbox mailbox;
  static_assert(sizeof(Payload) == tactus::firmware::kMaxFrameSize);
  exchange(
      [&](std::uint64_t n, Delays&) {
        Payload payload;
        fill(payload, n);
        mailbox.write(std::as_bytes(std::span(payload)));
      },
      [&](std::uint64_t newest, Delays&) -> std::uint64_t {
        std::array<std::byte, tactus::firmware::kMaxFrameSize> bytes;
        if (mailbox.take(bytes) == 0) return 0;
        Payload payload;
        std::memcpy(payload.data(), bytes.data(), sizeof payload);
        check(payload, newest);
        return payload[0];
      });
}

// All that are not dropped arrive, in order: at the end the newest.
void exchange_commands() {
  tactus::firmware::CommandQueue queue;
  exchange(
      [&](std::uint64_t n, Delays&) {
        Payload payload;
        fill(payload, n);
        queue.write(std::as_bytes(std::span(payload)));
      },
      [&](std::uint64_t newest, Delays&) -> std::uint64_t {
        std::array<std::byte, tactus::firmware::kMaxFrameSize> bytes;
        if (queue.take(bytes) == 0) return 0;
        Payload payload;
        std::memcpy(payload.data(), bytes.data(), sizeof payload);
        check(payload, newest);
        return payload[0];
      });
}

}  // namespace

int main(int argc, char** argv) {
  constexpr std::memory_order kBoth = std::memory_order_acq_rel;
  constexpr std::memory_order kRelease = std::memory_order_release, kAcquire = std::memory_order_acquire;
  const char* variant = argc > 1 ? argv[1] : "ordered";
  if (std::strcmp(variant, "ordered") == 0) {
    exchange_latest<kBoth, kBoth>();
    exchange_mailbox();
    exchange_commands();
  } else if (std::strcmp(variant, "publish-without-release") == 0) {
    exchange_latest<kAcquire, kBoth>();
  } else if (std::strcmp(variant, "publish-without-acquire") == 0) {
    exchange_latest<kRelease, kBoth>();
  } else if (std::strcmp(variant, "take-without-release") == 0) {
    exchange_latest<kBoth, kAcquire>();
  } else if (std::strcmp(variant, "take-without-acquire") == 0) {
    exchange_latest<kBoth, kRelease>();
  } else {
    std::printf("no variant '%s'\n", variant);
    return 2;
  }
  std::puts("all values arrived whole");
  return 0;
}
