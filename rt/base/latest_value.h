// The newest value from one thread to another, between two that run at rates of their own: no wait on either side, and
// what nobody looked at in time is counted, not queued.
//
// A free-running producer may publish any number of times while the consumer looks at one value: two buffers would not
// do (see double_buffer.h for two that alternate), three do. One is being written, one is being read, the third lies
// between, with a mark that says whether anybody has seen it. Either side exchanges its own buffer with the one between
// in one atomic operation. Each exchange hands a buffer over and takes one up, so four edges order the memory:
//   publish, release: the value is written before the consumer can get it.
//   take, acquire:    ... and read after that. Nobody sees half a value.
//   take, release:    the reads of the old value are done before the producer can get its buffer back.
//   publish, acquire: ... and writes come after that. Nobody's value changes under the eyes.
// Both sides' exchanges read what the other's wrote, so each release meets the acquire of the other side; an exchange
// of one side between two of the other only continues the chain. The race test weakens each of the four and sees the
// race. The look at the mark before a take needs no order: it only saves the exchange.
// Thread: writing(), publish(): the producer [rt]; take(): the consumer [rt]; superseded() [any]. Construction [setup].
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <type_traits>

#include "rt/base/double_buffer.h"

namespace tactus {

// The memory orders are parameters only so that a test can weaken one and see the race detector fire.
template <class Value, std::memory_order kPublish = std::memory_order_acq_rel,
          std::memory_order kTake = std::memory_order_acq_rel>
class LatestValue {
  static_assert(std::is_trivially_copyable_v<Value>, "values cross a thread");
  static_assert(std::atomic<std::uint32_t>::is_always_lock_free && std::atomic<std::uint64_t>::is_always_lock_free);

 public:
  // The producer's buffer, with whatever an older value left in it: write all of it, then publish.
  Value& writing() noexcept { return buffers_[writing_].value; }

  // True: it replaced a value that the consumer never saw.
  bool publish() noexcept {
    const std::uint32_t before = between_.exchange(writing_ | kUnseen, kPublish);
    writing_ = before & kIndex;
    const bool replaced = (before & kUnseen) != 0;
    // One writer: no read-modify-write needed.
    if (replaced) superseded_.store(superseded_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
    return replaced;
  }

  // The newest value that was not taken yet, or null. It stays as it is until the next take().
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
  alignas(kCacheLine) std::uint32_t writing_{0};  // the producer's line
  std::atomic<std::uint64_t> superseded_{0};
  alignas(kCacheLine) std::uint32_t reading_{2};  // the consumer's line
};

}  // namespace tactus
