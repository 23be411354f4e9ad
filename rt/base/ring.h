// A byte ring for records of any length, from one thread to another: tick records to the tape, events to the screen.
//
// One producer, one consumer; neither waits. A record that does not fit is dropped whole and counted; the next record
// that fits carries the number of dropped ones, so the consumer knows where the gap is.
// Thread: construction [setup]; try_begin, append, commit, try_push: the producer [rt]; try_pop: the consumer;
// dropped(): [any]. Bound: the capacity in bytes, a power of two; a record takes its size + 16, rounded up to 16.
//
// Memory order. Only the producer writes head_, only the consumer writes tail_; both count bytes and never wrap (2^64).
// The producer's bytes are before its release-store of head_; the consumer acquires head_ before it reads them. The
// consumer's reads are before its release-store of tail_; the producer acquires tail_ before it overwrites them. Each
// side caches the other's counter and reloads it only when the ring seems full or empty: the cached value can only be
// too old, which is safe, and the counters' cache lines move once per lap instead of once per record.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>

#include "rt/base/check.h"
#include "rt/base/double_buffer.h"

namespace tactus {

struct RingRecord {
  std::uint32_t kind{0};
  std::uint32_t size{0};         // bytes of payload
  std::uint64_t lost_before{0};  // records dropped between the previous one and this one
};

enum class Pop : std::uint32_t {
  kEmpty = 0,
  kRecord = 1,
  kTooLarge = 2,  // the payload does not fit the span: skipped; the record contains its size
};

// The memory orders are parameters only so that a test can weaken one and check that the race detector reports it.
template <std::memory_order kRelease = std::memory_order_release,
          std::memory_order kAcquire = std::memory_order_acquire>
class BasicRing {
 public:
  explicit BasicRing(std::uint64_t capacity_bytes)
      : bytes_(std::make_unique<std::byte[]>(capacity_bytes)), capacity_(capacity_bytes) {
    TACTUS_CHECK(capacity_ >= 64 && (capacity_ & (capacity_ - 1)) == 0, capacity_, 0);
  }

  // --- producer
  // Reserves space for one record; false, and one more dropped, if there is none. A begin without commit has no effect.
  [[nodiscard]] bool try_begin(std::uint32_t kind, std::uint32_t size) noexcept {
    const std::uint64_t head = head_.load(std::memory_order_relaxed);
    const std::uint64_t need = kHeader + rounded(size);
    begin_ = end_ = 0;
    if (capacity_ - (head - seen_tail_) < need) {
      seen_tail_ = tail_.load(kAcquire);
      if (capacity_ - (head - seen_tail_) < need) {
        ++sequence_;
        dropped_.store(dropped_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
        return false;
      }
    }
    const Header header{kind, size, sequence_};
    copy_in(head, std::as_bytes(std::span<const Header, 1>(&header, 1)));
    begin_ = head + kHeader;
    end_ = begin_ + size;
    return true;
  }

  // Appends the next bytes of the payload.
  void append(std::span<const std::byte> bytes) noexcept {
    TACTUS_CHECK(bytes.size() <= end_ - begin_, bytes.size(), end_ - begin_);
    copy_in(begin_, bytes);
    begin_ += bytes.size();
  }

  // Publishes the record. The payload must be complete.
  void commit() noexcept {
    TACTUS_CHECK(end_ > 0 && begin_ == end_, begin_, end_);
    ++sequence_;
    const std::uint64_t head = rounded(end_);
    begin_ = end_ = 0;
    head_.store(head, kRelease);
  }

  // Pushes one record whose payload is the concatenated spans.
  template <class... Spans>
  [[nodiscard]] bool try_push(std::uint32_t kind, const Spans&... payload) noexcept {
    const std::size_t size = (std::size_t{0} + ... + std::span(payload).size_bytes());
    TACTUS_CHECK(size <= 0xffffffffu, size, 0);
    if (!try_begin(kind, static_cast<std::uint32_t>(size))) return false;
    (append(std::as_bytes(std::span(payload))), ...);
    commit();
    return true;
  }

  // --- consumer
  // Pops the oldest record; its payload goes to the front of `out`.
  Pop try_pop(RingRecord& record, std::span<std::byte> out) noexcept {
    const std::uint64_t tail = tail_.load(std::memory_order_relaxed);
    if (seen_head_ == tail) {
      seen_head_ = head_.load(kAcquire);
      if (seen_head_ == tail) return Pop::kEmpty;
    }
    Header header;
    copy_out(tail, std::as_writable_bytes(std::span<Header, 1>(&header, 1)));
    record = {.kind = header.kind, .size = header.size, .lost_before = header.sequence - expected_};
    expected_ = header.sequence + 1;
    const bool fits = header.size <= out.size();
    if (fits) copy_out(tail + kHeader, out.first(header.size));
    tail_.store(tail + kHeader + rounded(header.size), kRelease);
    return fits ? Pop::kRecord : Pop::kTooLarge;
  }

  // --- any
  std::uint64_t capacity() const noexcept { return capacity_; }
  std::uint64_t dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }

 private:
  struct Header {
    std::uint32_t kind{0}, size{0};
    std::uint64_t sequence{0};  // includes dropped records
  };
  static constexpr std::uint64_t kHeader = sizeof(Header);
  static_assert(kHeader == 16);

  static constexpr std::uint64_t rounded(std::uint64_t bytes) noexcept { return (bytes + 15) & ~std::uint64_t{15}; }

  void copy_in(std::uint64_t at, std::span<const std::byte> from) noexcept {
    if (from.empty()) return;
    const std::uint64_t place = at & (capacity_ - 1), first = std::min<std::uint64_t>(from.size(), capacity_ - place);
    std::memcpy(bytes_.get() + place, from.data(), first);
    std::memcpy(bytes_.get(), from.data() + first, from.size() - first);
  }
  void copy_out(std::uint64_t at, std::span<std::byte> to) const noexcept {
    if (to.empty()) return;
    const std::uint64_t place = at & (capacity_ - 1), first = std::min<std::uint64_t>(to.size(), capacity_ - place);
    std::memcpy(to.data(), bytes_.get() + place, first);
    std::memcpy(to.data() + first, bytes_.get(), to.size() - first);
  }

  std::unique_ptr<std::byte[]> bytes_;
  std::uint64_t capacity_;
  // On the producer's cache line.
  alignas(kCacheLine) std::atomic<std::uint64_t> head_{0};
  std::uint64_t seen_tail_{0}, sequence_{0}, begin_{0}, end_{0};
  std::atomic<std::uint64_t> dropped_{0};
  // On the consumer's cache line.
  alignas(kCacheLine) std::atomic<std::uint64_t> tail_{0};
  std::uint64_t seen_head_{0}, expected_{0};
};

using Ring = BasicRing<>;

}  // namespace tactus
