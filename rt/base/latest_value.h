// Passes the newest value from one thread to another when both run at independent rates. Neither side waits; values
// that were not read in time are counted, not queued.
//
// A free-running producer may publish any number of times while the consumer reads one value, so two buffers are not
// enough (double_buffer.h is for two sides that alternate); three are. One is being written, one is being read, the
// third is in between, with a flag for a value that was not taken yet. Either side exchanges its own buffer with the
// third in one atomic operation. Each exchange passes on one buffer and receives another, so there are four orderings:
//   publish, release: the value is written before the consumer can get it.
//   take, acquire:    the consumer reads after it got it. It never sees a partial value.
//   take, release:    the reads of the old value are done before the producer can get its buffer back.
//   publish, acquire: the producer writes after it got it back. No value changes while it is read.
// Each side's exchange reads the value that the other's wrote, so each release pairs with the other side's acquire; an
// exchange of one side between two of the other continues the release sequence. The race test weakens each of the four
// and detects the race. The test of the flag before a take needs no order: it only avoids a needless exchange.
// Thread: writing(), publish(): the producer [rt]; take(): the consumer [rt]; superseded() [any]. Construction [setup].
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <type_traits>

#include "rt/base/double_buffer.h"

namespace tactus {

// The memory orders are parameters only so that a test can weaken one and check that the race detector reports it.
template <class Value, std::memory_order kPublish = std::memory_order_acq_rel,
          std::memory_order kTake = std::memory_order_acq_rel>
class LatestValue {
  static_assert(std::is_trivially_copyable_v<Value>, "values cross a thread");
  static_assert(std::atomic<std::uint32_t>::is_always_lock_free && std::atomic<std::uint64_t>::is_always_lock_free);

 public:
  // The producer's buffer; it contains an older value: overwrite all of it, then publish.
  Value& writing() noexcept { return buffers_[writing_].value; }

  // Returns true if it replaced a value that the consumer did not take.
  bool publish() noexcept {
    const std::uint32_t before = between_.exchange(writing_ | kUnseen, kPublish);
    writing_ = before & kIndex;
    const bool replaced = (before & kUnseen) != 0;
    // Single writer: no atomic read-modify-write needed.
    if (replaced) superseded_.store(superseded_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
    return replaced;
  }

  // Returns the newest value that was not taken yet, or null. It does not change until the next take().
  const Value* take() noexcept {
    if ((between_.load(std::memory_order_relaxed) & kUnseen) == 0) return nullptr;
    reading_ = between_.exchange(reading_, kTake) & kIndex;
    return &buffers_[reading_].value;
  }

  // Values published that were replaced before they were taken.
  std::uint64_t superseded() const noexcept { return superseded_.load(std::memory_order_relaxed); }

 private:
  static constexpr std::uint32_t kIndex = 3, kUnseen = 4;

  struct alignas(kCacheLine) Buffer {
    Value value{};
  };
  std::array<Buffer, 3> buffers_{};
  alignas(kCacheLine) std::atomic<std::uint32_t> between_{1};
  alignas(kCacheLine) std::uint32_t writing_{0};  // on the producer's cache line
  std::atomic<std::uint64_t> superseded_{0};
  alignas(kCacheLine) std::uint32_t reading_{2};  // on the consumer's cache line
};

}  // namespace tactus
