// One direction of the exchange between the two worlds: values numbered 0, 1, 2 ..., two buffers, one writer, one
// reader, no wait on either side.
//
// Strict alternation makes it safe: value n lives in buffer n & 1, and the writer begins n only after it knows, by the
// other direction's sequence number, that the reader has done with n - 2. The exchange as a whole guarantees that
// (see rt/haptics/exchange.h); this class only orders memory: what was written before publish(n) is seen by whoever
// saw n. Thread: writing(), publish(): the writer [rt]; try_read(): the reader [rt]. Construction [setup].
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <type_traits>

namespace tactus {

inline constexpr std::size_t kCacheLine = 64;

// The memory orders are parameters only so that a test can weaken one and see the race detector fire.
template <class Value, std::memory_order kPublish = std::memory_order_release,
          std::memory_order kRead = std::memory_order_acquire>
class DoubleBuffer {
  static_assert(std::is_trivially_copyable_v<Value>, "values cross a thread");
  static_assert(std::atomic<std::uint64_t>::is_always_lock_free);

 public:
  DoubleBuffer() : buffers_(std::make_unique<Value[]>(2)) {}  // [setup] on the heap: snapshots are large

  Value& writing(std::uint64_t n) noexcept { return buffers_[n & 1]; }

  // Release: the value's bytes are visible to the reader before its number is.
  void publish(std::uint64_t n) noexcept { published_.store(n + 1, kPublish); }

  // The value n, or null while it is not there. Acquire: pairs with publish.
  const Value* try_read(std::uint64_t n) const noexcept {
    return published_.load(kRead) > n ? &buffers_[n & 1] : nullptr;
  }

 private:
  std::unique_ptr<Value[]> buffers_;
  alignas(kCacheLine) std::atomic<std::uint64_t> published_{0};  // how many values were published
  char fill_[kCacheLine - sizeof(std::atomic<std::uint64_t>)]{};  // the two directions' numbers share no line
};

}  // namespace tactus
