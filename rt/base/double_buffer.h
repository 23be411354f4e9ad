// One direction of the exchange between the two worlds: values numbered 0, 1, 2 ..., two buffers, one writer, one
// reader; neither side waits.
//
// Strict alternation makes it safe: value n is in buffer n & 1, and the writer starts n only after it knows, by the
// other direction's sequence number, that the reader has finished with n - 2 (rt/haptics/coupling/exchange.h). Two
// happens-before edges are needed:
//   down: write of n -> publish(n), release -> try_read(n), acquire -> reads of n.
//         The reader never sees a partial value.
//   up:   reads of n - 2 -> the reader's publish() in the other direction, release
//         -> the writer's try_read() there, acquire -> write of n.
//         No value changes while it is read: without the release on this edge the reads of n - 2 could still be in
//         progress when its buffer is written again.
// Relaxed accesses suffice for neither edge: the race test weakens each of the four orders and detects the race.
// Thread: writing(), publish(): the writer [rt]; try_read(): the reader [rt]. Construction [setup].
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <type_traits>

#include "rt/base/check.h"

namespace tactus {

inline constexpr std::size_t kCacheLine = 64;

// The memory orders are parameters only so that a test can weaken one and check that the race detector reports it.
template <class Value, std::memory_order kPublish = std::memory_order_release,
          std::memory_order kRead = std::memory_order_acquire>
class DoubleBuffer {
  static_assert(std::is_trivially_copyable_v<Value>, "values cross a thread");
  static_assert(std::atomic<std::uint64_t>::is_always_lock_free);

 public:
  DoubleBuffer() : buffers_(std::make_unique<Value[]>(2)) {}  // [setup]; on the heap, because snapshots are large

  Value& writing(std::uint64_t n) noexcept { return buffers_[n & 1]; }

  // [setup] Both values and their number; neither side may use either buffer meanwhile.
  void copy_from(const DoubleBuffer& other) noexcept {
    std::copy_n(other.buffers_.get(), 2, buffers_.get());
    published_.store(other.published_.load(std::memory_order_relaxed), std::memory_order_relaxed);
  }

  // Release: the reader sees the value's bytes before its number.
  void publish(std::uint64_t n) noexcept { published_.store(n + 1, kPublish); }

  // Returns the value n, or null if it is not published yet. Acquire: pairs with publish.
  const Value* try_read(std::uint64_t n) const noexcept {
    const std::uint64_t published = published_.load(kRead);
    if (published <= n) return nullptr;
    TACTUS_CHECK(published - n <= 2, published, n);  // else n + 2 is already in its buffer: a side skipped a number
    return &buffers_[n & 1];
  }

 private:
  std::unique_ptr<Value[]> buffers_;
  alignas(kCacheLine) std::atomic<std::uint64_t> published_{0};   // number of published values
  char fill_[kCacheLine - sizeof(std::atomic<std::uint64_t>)]{};  // each direction's number has its own line
};

}  // namespace tactus
