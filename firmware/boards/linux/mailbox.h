// The newest frame from one thread to another, on a Linux board whose link has threads of its own.
//
// Three slots: one is being written, one is being read, the third lies between with a mark that says whether anybody
// has read it. Either side exchanges its own slot with the one between, in one atomic operation: nobody waits, nobody
// sees half a frame, the reader always gets the newest. Release hands a slot over, acquire takes one up, on both sides:
// the writer gets a slot back that the reader has read to the end. (rt/base/latest_value.h is the same on the host,
// which firmware/ does not include; tests/tsan/latest_value_race.cpp runs both under the race detector.) Thread:
// write(): one; take(): one other; [rt] both. Bound: one exchange and a copy of 64 bytes at most.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/protocol.h"

namespace tactus::firmware {

class Mailbox {
 public:
  // A longer frame than the wire has is cut. True: a frame that nobody had read was replaced.
  bool write(std::span<const std::byte> frame) noexcept {
    Slot& slot = slots_[writing_];
    slot.size = std::min(frame.size(), slot.bytes.size());
    std::copy_n(frame.begin(), slot.size, slot.bytes.begin());
    const std::uint8_t before =
        between_.exchange(static_cast<std::uint8_t>(writing_ | kUnread), std::memory_order_acq_rel);
    writing_ = before & kIndex;
    return (before & kUnread) != 0;
  }

  // The frame that came since the last call, into `out`, and its size; 0: none.
  std::size_t take(std::span<std::byte, kMaxFrameSize> out) noexcept {
    if ((between_.load(std::memory_order_relaxed) & kUnread) == 0) return 0;
    reading_ = between_.exchange(reading_, std::memory_order_acq_rel) & kIndex;
    const Slot& slot = slots_[reading_];
    std::copy_n(slot.bytes.begin(), slot.size, out.begin());
    return slot.size;
  }

 private:
  static constexpr std::uint8_t kIndex = 3, kUnread = 4;

  struct alignas(64) Slot {
    std::size_t size{0};
    std::array<std::byte, kMaxFrameSize> bytes{};
  };
  std::array<Slot, 3> slots_{};
  std::atomic<std::uint8_t> between_{1};
  std::uint8_t writing_{0}, reading_{2};  // each its own side's
};

}  // namespace tactus::firmware
