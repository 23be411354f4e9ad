// The synthetic sub-worlds of the calibration: haptic loops of known work, whose state does not change from tick to
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

  // Runs one tick; returns its time and its counts for the cost model.
  TimedWork tick(std::uint32_t sub_steps);
  // The same with the adoption of a snapshot of the same members.
  TimedWork tick_synchronising(std::uint32_t sub_steps);
  // The same with half of the members joining; an untimed tick before it removes them.
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
