// The rule for a late global world, whose next snapshot has not arrived within the cycle's r ticks. Outside velocities
// fade to 0 over the next r ticks. More than 4 r ticks late: the border freezes. More than 100 ms late: the force fades
// out. All of it ends with the next snapshot. Thread: [rt], pure. Units: SI. Bound: constant time.
#pragma once

#include <algorithm>
#include <cstdint>

#include "rt/base/status.h"

namespace tactus::haptics {

struct WorldLateness {
  // Lateness beyond which the global world counts as lost and the force fades out; it recovers without a re-arm.
  static constexpr double kLostAfter_s = 0.1;
  static constexpr double kFadeTicks = 10;
  static constexpr std::uint32_t kFreezeAfterCycles = 4;

  std::uint32_t ticks{0};   // late ticks, this one included; 0: in time
  double surface_share{1};  // factor on the outside surfaces' velocity of the snapshot
  double ghost_share{1};    // factor on the ghosts' velocity and drive of the last tick
  double force_scale{1};
  std::uint32_t status{0};  // StatusBit

  bool border_frozen() const noexcept { return (status & kBorderFrozen) != 0; }

  // State in the tick of index `ticks_in_cycle` since the last snapshot, from 0.
  static WorldLateness in_tick(std::uint32_t ticks_in_cycle, std::uint32_t ratio, double period_s) noexcept {
    WorldLateness late;
    if (ticks_in_cycle < ratio) return late;
    late.ticks = ticks_in_cycle - ratio + 1;
    const auto share_of = [ratio](std::uint32_t late_ticks) noexcept {
      return std::max(0.0, 1.0 - static_cast<double>(late_ticks) / ratio);
    };
    late.surface_share = share_of(late.ticks);
    const double before = share_of(late.ticks - 1);
    late.ghost_share = before > 0 ? late.surface_share / before : 0.0;
    late.status = kWorldLate;
    if (late.ticks > kFreezeAfterCycles * ratio) late.status |= kBorderFrozen;
    const double lost_ticks = late.ticks - kLostAfter_s / period_s;
    if (lost_ticks > 0) {
      late.status |= kWorldFade;
      late.force_scale = std::max(0.0, 1.0 - lost_ticks / kFadeTicks);
    }
    return late;
  }
};

}  // namespace tactus::haptics
