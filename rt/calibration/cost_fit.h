// A core's cost table from the times of a few synthetic ticks, each made so that one kind of work stands out.
//
// No general least squares: each cost has one run, or the difference of two, that settles it once the others are known,
// and a few rounds over all of them settle them together. No cost is ever negative: what noise would make so is 0.
// Pure: the same times give the same table. Thread: [any]. Units: ns.
#pragma once

#include <array>

#include "rt/loop/governor.h"

namespace tactus::loop {

// The runs, by what they have more of than the ones before.
enum class CalibrationRun : std::uint32_t {
  kLone,           // the proxy alone
  kFree,           // bodies that touch nothing
  kFreeMore,       // "more": more sub-steps
  kApart,          // pairs that are known to be apart
  kBalls,          // contacts of one point
  kBallsMore,      //
  kCarried,        // boxes: contacts of four points, carried over
  kCarriedMore,    //
  kSearched,       // the same, found anew in every tick
  kBordered,       // border contacts
  kBorderedMore,   //
  kSynchronising,  // free bodies, adopting a snapshot
  kBorderedSynchronising,
  kJoining,  // free bodies, half of which a snapshot brings
};
inline constexpr std::uint32_t kCalibrationRuns = 14;

struct TimedWork {
  WorkCounts counts;
  std::uint32_t sub_steps{1};
  double ns{0};
};
using CalibrationTimes = std::array<TimedWork, kCalibrationRuns>;  // by CalibrationRun

CostModel fit_costs(const CalibrationTimes& times) noexcept;

}  // namespace tactus::loop
