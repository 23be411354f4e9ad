// Lock-free exchange between two threads of a Linux board's link: the newest state frame, and the newest commands in
// order.
//
// Triple buffer: one slot is being written, one is being read, the third is between them, marked as read or unread.
// Either side exchanges its own slot with the third in one atomic operation: no thread waits, no value is torn, the
// reader always gets the newest. The exchange has acquire-release order on both sides, so the writer reuses a slot only
// after the reader has finished with it. (rt/base/latest_value.h is the same on the host,
// which firmware/ does not include; tests/tsan/latest_value_race.cpp runs both under the race detector.) Thread: the
// writer's functions: one; take(): one other; [rt] both. Bound: one exchange and a copy, of one frame at most or, where
// a command is written, of kCapacity frames.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/protocol.h"

namespace tactus::firmware {

template <class T>
class ThreeSlots {
 public:
  T& writing() noexcept { return slots_[writing_].value; }
  // Writer: true if the last published value was unread. The reader may take it meanwhile.
  bool unread() const noexcept { return (between_.load(std::memory_order_relaxed) & kUnread) != 0; }
  // Returns true if an unread value was replaced.
  bool publish() noexcept {
    const std::uint8_t before =
        between_.exchange(static_cast<std::uint8_t>(writing_ | kUnread), std::memory_order_acq_rel);
    writing_ = before & kIndex;
    return (before & kUnread) != 0;
  }
  // The newest value published since the last call, valid until the next call; null: none.
  const T* take() noexcept {
    if (!unread()) return nullptr;
    reading_ = between_.exchange(reading_, std::memory_order_acq_rel) & kIndex;
    return &slots_[reading_].value;
  }

 private:
  static constexpr std::uint8_t kIndex = 3, kUnread = 4;

  struct alignas(64) Slot {
    T value{};
  };
  std::array<Slot, 3> slots_{};
  std::atomic<std::uint8_t> between_{1};
  std::uint8_t writing_{0}, reading_{2};  // indices owned by the writer, the reader
};

struct BoxedFrame {
  std::size_t size{0};
  std::array<std::byte, kMaxFrameSize> bytes{};

  // Truncates a frame longer than kMaxFrameSize.
  void put(std::span<const std::byte> frame) noexcept {
    size = std::min(frame.size(), bytes.size());
    std::copy_n(frame.begin(), size, bytes.begin());
  }
};

// The newest frame.
class Mailbox {
 public:
  // Returns true if an unread frame was replaced.
  bool write(std::span<const std::byte> frame) noexcept {
    slots_.writing().put(frame);
    return slots_.publish();
  }

  // Copies the newest frame since the last call into `out` and returns its size; 0: none.
  std::size_t take(std::span<std::byte, kMaxFrameSize> out) noexcept {
    const BoxedFrame* frame = slots_.take();
    if (frame == nullptr) return 0;
    std::copy_n(frame->bytes.begin(), frame->size, out.begin());
    return frame->size;
  }

 private:
  ThreeSlots<BoxedFrame> slots_;
};

// Queue of the newest kCapacity frames that have not been taken, oldest first. With each new frame the writer publishes
// all waiting ones; the reader skips those that it has already taken by their numbers.
class CommandQueue {
 public:
  static constexpr std::size_t kCapacity = 16;

  // Returns true if an untaken frame was waiting.
  bool write(std::span<const std::byte> frame) noexcept {
    const bool waits = slots_.unread();
    if (!waits) waiting_.count = 0;
    if (waiting_.count == kCapacity) {
      std::copy(waiting_.frames.begin() + 1, waiting_.frames.end(), waiting_.frames.begin());
      --waiting_.count;
    }
    waiting_.frames[waiting_.count++].put(frame);
    ++waiting_.end;
    slots_.writing() = waiting_;
    (void)slots_.publish();
    return waits;
  }

  // Copies the oldest waiting frame into `out` and returns its size; 0: none.
  std::size_t take(std::span<std::byte, kMaxFrameSize> out) noexcept {
    if (reading_ == nullptr || next_ == reading_->end) {
      const Frames* newer = slots_.take();
      if (newer == nullptr) return 0;
      reading_ = newer;
      next_ = std::max(next_, newer->end - newer->count);
      if (next_ == newer->end) return 0;
    }
    const BoxedFrame& frame = reading_->frames[reading_->count - static_cast<std::size_t>(reading_->end - next_)];
    ++next_;
    std::copy_n(frame.bytes.begin(), frame.size, out.begin());
    return frame.size;
  }

 private:
  struct Frames {
    std::uint64_t end{0};  // number of the last frame plus one
    std::size_t count{0};
    std::array<BoxedFrame, kCapacity> frames{};
  };

  ThreeSlots<Frames> slots_;
  Frames waiting_;                  // owned by the writer
  const Frames* reading_{nullptr};  // owned by the reader
  std::uint64_t next_{0};           // owned by the reader: number of the next frame to take
};

}  // namespace tactus::firmware
