// One direction of a simulated link with a delay: a frame arrives at a later tick.
//
// If several frames arrive in the same tick, the one sent last is kept, as in a receiver's mailbox.
// Thread: [rt], the owner's. Bound: a frame arrives at most kMaxAhead ticks after it was sent; 128 slots, no
// allocation.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/protocol.h"
#include "rt/base/check.h"

namespace tactus::hal {

class SimulatedLink {
 public:
  static constexpr std::uint64_t kMaxAhead = 127;

  // `bytes`: at most firmware::kMaxFrameSize.
  void send(std::uint64_t sent_tick, std::uint64_t arrival_tick, std::span<const std::byte> bytes) noexcept {
    TACTUS_CHECK(arrival_tick >= sent_tick && arrival_tick - sent_tick <= kMaxAhead, sent_tick, arrival_tick);
    TACTUS_CHECK(bytes.size() <= firmware::kMaxFrameSize, bytes.size(), firmware::kMaxFrameSize);
    Slot& slot = slots_[arrival_tick % slots_.size()];
    const bool taken = slot.size > 0 && slot.arrival_tick == arrival_tick;
    if (taken && slot.sent_tick > sent_tick) return;
    slot.sent_tick = sent_tick;
    slot.arrival_tick = arrival_tick;
    slot.size = bytes.size();
    std::copy(bytes.begin(), bytes.end(), slot.bytes.begin());
  }

  // The frame that arrives at `tick`; empty if none. Valid until the next send.
  std::span<const std::byte> arriving(std::uint64_t tick) const noexcept {
    const Slot& slot = slots_[tick % slots_.size()];
    return {slot.bytes.data(), slot.arrival_tick == tick ? slot.size : 0};
  }

  // Drops all frames in transit.
  void clear() noexcept {
    for (Slot& slot : slots_) slot.size = 0;
  }

 private:
  struct Slot {
    std::uint64_t sent_tick{0}, arrival_tick{0};
    std::size_t size{0};
    std::array<std::byte, firmware::kMaxFrameSize> bytes{};
  };
  std::array<Slot, kMaxAhead + 1> slots_{};
};

}  // namespace tactus::hal
