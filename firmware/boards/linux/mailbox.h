// Values from one thread to another, on a Linux board whose link has threads of its own: the newest state frame, and
// the newest commands in their order.
//
// Three slots: one is being written, one is being read, the third lies between with a mark that says whether anybody
// has read it. Either side exchanges its own slot with the one between, in one atomic operation: nobody waits, nobody
// sees half a value, the reader always gets the newest. Release hands a slot over, acquire takes one up, on both sides:
// the writer gets a slot back that the reader has read to the end. (rt/base/latest_value.h is the same on the host,
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
  // Writer: is what was published last still unread? The reader may take it meanwhile.
  bool unread() const noexcept { return (between_.load(std::memory_order_relaxed) & kUnread) != 0; }
  // True: a value that nobody had read was replaced.
  bool publish() noexcept {
    const std::uint8_t before =
        between_.exchange(static_cast<std::uint8_t>(writing_ | kUnread), std::memory_order_acq_rel);
    writing_ = before & kIndex;
    return (before & kUnread) != 0;
  }
  // The value that was published since the last call, until the next; null: none.
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
  std::uint8_t writing_{0}, reading_{2};  // each its own side's
};

struct BoxedFrame {
  std::size_t size{0};
  std::array<std::byte, kMaxFrameSize> bytes{};

  // A longer frame than the wire has is cut.
  void put(std::span<const std::byte> frame) noexcept {
    size = std::min(frame.size(), bytes.size());
    std::copy_n(frame.begin(), size, bytes.begin());
  }
};

// The newest frame.
class Mailbox {
 public:
  // True: a frame that nobody had read was replaced.
  bool write(std::span<const std::byte> frame) noexcept {
    slots_.writing().put(frame);
    return slots_.publish();
  }

  // The frame that came since the last call, into `out`, and its size; 0: none.
  std::size_t take(std::span<std::byte, kMaxFrameSize> out) noexcept {
    const BoxedFrame* frame = slots_.take();
    if (frame == nullptr) return 0;
    std::copy_n(frame->bytes.begin(), frame->size, out.begin());
    return frame->size;
  }

 private:
  ThreeSlots<BoxedFrame> slots_;
};

// The newest kCapacity frames that nobody has taken, oldest first. The writer publishes all that wait with each that
// comes; where the reader took some meanwhile, it knows them by their number.
class CommandQueue {
 public:
  static constexpr std::size_t kCapacity = 16;

  // True: a frame that nobody had taken was there.
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

  // The oldest frame that waits, into `out`, and its size; 0: none.
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
    std::uint64_t end{0};  // the number of the frame after the last
    std::size_t count{0};
    std::array<BoxedFrame, kCapacity> frames{};
  };

  ThreeSlots<Frames> slots_;
  Frames waiting_;                  // the writer's
  const Frames* reading_{nullptr};  // the reader's
  std::uint64_t next_{0};           // the reader's: the number of the frame to take next
};

}  // namespace tactus::firmware
