// Timer of the control period and the device's clock, both from SysTick.
//
// Thread: tick() in SysTick's handler; the rest the control period's, [rt]. Bound: a 64-bit microsecond clock never
// wraps; ticks missed during a long period are counted and skipped. SysTick has 24 bits: at 25 MHz the longest period
// is 671 ms.
#pragma once

#include <atomic>
#include <cstdint>

#include "firmware/boards/cortex_m/cortex_m4.h"

namespace tactus::firmware::cortex_m {

class PeriodClock {
 public:
  // [setup] Starts the timer. False if the period does not fit the counter: the timer does not start.
  bool start(SysTickRegisters& timer, std::uint32_t clock_Hz, std::uint32_t period_us) noexcept {
    const std::uint64_t counts = std::uint64_t{clock_Hz} * period_us / 1'000'000;
    if (counts < 2 || counts - 1 > kSysTickMaxReload) return false;
    timer_ = &timer;
    period_us_ = period_us;
    reload_ = static_cast<std::uint32_t>(counts) - 1;
    timer.reload = reload_;
    timer.current = 0;
    timer.control = kSysTickRuns;
    return true;
  }

  void tick() noexcept { ticks_.store(ticks_.load(std::memory_order_relaxed) + 1, std::memory_order_release); }

  // True if a new period is due; starts it, and counts the periods missed before it.
  bool take_tick() noexcept {
    const std::uint32_t ticks = ticks_.load(std::memory_order_acquire);
    const std::uint32_t passed = ticks - taken_;
    if (passed == 0) return false;
    taken_ = ticks;
    period_start_us_ += std::uint64_t{passed} * period_us_;
    if (passed - 1 > ~std::uint32_t{0} - missed_)
      missed_ = ~std::uint32_t{0};
    else
      missed_ += passed - 1;
    return true;
  }

  // Time since start(), within the present period; monotone also if the next tick occurs meanwhile.
  std::uint64_t now_us() const noexcept {
    const std::uint32_t elapsed = reload_ - timer_->current;
    const bool next_is_due = ticks_.load(std::memory_order_acquire) != taken_;
    const std::uint32_t counts_per_period = reload_ + 1;
    // The product would exceed 32 bits, and a 64-bit division would be a library call: use a float fraction.
    const float share = next_is_due ? 1.0f : static_cast<float>(elapsed) / static_cast<float>(counts_per_period);
    return period_start_us_ + static_cast<std::uint32_t>(share * static_cast<float>(period_us_));
  }

  std::uint32_t missed() const noexcept { return missed_; }  // saturates

 private:
  SysTickRegisters* timer_{nullptr};
  std::uint32_t period_us_{0}, reload_{0};
  std::atomic<std::uint32_t> ticks_{0};
  std::uint32_t taken_{0}, missed_{0};
  std::uint64_t period_start_us_{0};
};

}  // namespace tactus::firmware::cortex_m
