// The synthetic sub-worlds of the calibration: haptic loops of known work, that stay as they are however often they
// tick.
//
// Thread: [setup], on the core that is measured. Bound: kCalibrationBodies bodies, twice as many border contacts.
#pragma once

#include <memory>

#include "rt/calibration/cost_fit.h"
#include "rt/loop/haptic_loop.h"

namespace tactus::loop {

inline constexpr std::uint32_t kCalibrationBodies = 48;

enum class SyntheticWorld { kLone, kFree, kApart, kBalls, kCarried, kSearched, kBordered };

class CalibrationWorld {
 public:
  explicit CalibrationWorld(SyntheticWorld kind);

  // One tick. Its time, and what the cost model goes by.
  TimedWork tick(std::uint32_t sub_steps);
  // One that adopts a snapshot of the same members.
  TimedWork tick_synchronising(std::uint32_t sub_steps);
  // One that half of the members join; they left in a tick before it, which is not told of.
  TimedWork tick_joining(std::uint32_t sub_steps);

 private:
  TimedWork tick(std::uint32_t sub_steps, const haptics::WorldSnapshot* snapshot);

  HapticLoop loop_;
  std::unique_ptr<haptics::WorldSnapshot> all_, half_, none_new_;
  std::unique_ptr<haptics::SubWorldReport> report_;
  TickInput in_;
  TickOutput out_;
};

}  // namespace tactus::loop
