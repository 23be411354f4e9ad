// The host's GPIO lines as each of several hands has them: one set of lines, a haptic thread for each hand.
//
//   estop       stops every hand. Each thread reads the level itself in each of its ticks, so a thread that
//               hangs or has ended does not prevent the others from seeing the e-stop. A press between two ticks is
//               reported to every hand at its next tick.
//   enable      active while any hand requests force: a fault of one hand does not remove the others' force
//   probe       active while tick() of the first hand runs
//   heartbeat   toggles once every hand has ticked since the last toggle: it stops if any of the threads stops
//
// Only the first hand's thread sets the outputs: a change by another hand takes effect at the first hand's next tick.
// Thread: share(), off(), destruction [setup]; the rest [rt], a hand by one thread. No lock, no allocation, no throw.
// Bound: as GpioLines; of several hands one read more a tick, and a loop over kMaxHands.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "hal/gpio/gpio_lines.h"

namespace tactus::hal {

// `Lines`: GpioLines, or a stand-in in tests.
template <class Lines>
class SharedLines {
 public:
  static constexpr unsigned kMaxHands = 8;

  // `hands`: 1 to kMaxHands.
  static std::vector<std::unique_ptr<SharedLines>> share(std::unique_ptr<Lines> lines, unsigned hands) {
    const auto common = std::make_shared<Common>();
    common->lines = std::move(lines);
    common->hands = hands;
    std::vector<std::unique_ptr<SharedLines>> all;
    for (unsigned hand = 0; hand < hands; ++hand) all.emplace_back(new SharedLines(common, hand));
    return all;
  }

  // True if the e-stop is active now or was active since this hand's last call, however briefly.
  bool estop() noexcept {
    if (common_->hands == 1) return common_->lines->estop();
    if (common_->lines->estop_edge()) common_->stops.fetch_add(1, kRelaxed);
    const std::uint32_t stops = common_->stops.load(kRelaxed);
    const bool was_active = stops != stops_seen_;
    stops_seen_ = stops;
    return common_->lines->estop_level() || was_active;
  }

  void enable(bool on) noexcept {
    const std::uint32_t own = 1u << hand_;
    const std::uint32_t wanted =
        on ? common_->wanted.fetch_or(own, kRelaxed) | own : common_->wanted.fetch_and(~own, kRelaxed) & ~own;
    if (hand_ == 0) common_->lines->enable(wanted != 0);
  }

  void probe(bool active) noexcept {
    if (hand_ == 0) common_->lines->probe(active);
  }

  void heartbeat() noexcept {
    if (hand_ != 0) {
      common_->beats[hand_].fetch_add(1, kRelaxed);
      return;
    }
    for (unsigned hand = 1; hand < common_->hands; ++hand)
      if (common_->beats[hand].load(kRelaxed) == beats_seen_[hand]) return;
    for (unsigned hand = 1; hand < common_->hands; ++hand) beats_seen_[hand] = common_->beats[hand].load(kRelaxed);
    common_->lines->heartbeat();
  }

  // [setup] No hand requests force any more: after the threads have ended.
  void off() noexcept {
    common_->wanted.store(0, kRelaxed);
    common_->lines->enable(false);
  }

 private:
  static constexpr auto kRelaxed = std::memory_order_relaxed;

  struct Common {
    std::unique_ptr<Lines> lines;
    unsigned hands{1};
    std::atomic<std::uint32_t> stops{0};   // times that the e-stop was seen to become active
    std::atomic<std::uint32_t> wanted{0};  // bit by hand: it requests force
    std::array<std::atomic<std::uint32_t>, kMaxHands> beats{};
  };

  SharedLines(std::shared_ptr<Common> common, unsigned hand) : common_(std::move(common)), hand_(hand) {}

  std::shared_ptr<Common> common_;
  unsigned hand_;
  std::uint32_t stops_seen_{0};
  std::array<std::uint32_t, kMaxHands> beats_seen_{};
};

using HandLines = SharedLines<GpioLines>;

}  // namespace tactus::hal
