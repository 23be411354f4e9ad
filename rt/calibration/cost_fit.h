// Fits a core's cost table to the times of a few synthetic ticks, each dominated by one kind of work.
//
// Not a general least-squares fit: each cost is determined by one run, or by the difference of two, given the other
// costs; a fixed number of rounds over all costs solves them together. Costs are clamped to >= 0 against noise. Pure:
// equal times give an equal table. Thread: [any]. Units: ns.
#pragma once

#include <array>

#include "rt/loop/governor.h"

namespace tactus::loop {

// The runs, named by the work that they add.
enum class CalibrationRun : std::uint32_t {
  kLone,           // the proxy alone
  kFree,           // bodies without contacts
  kFreeMore,       // "More": the same with more sub-steps
  kApart,          // pairs known to be separated
  kBalls,          // contacts of one point
  kBallsMore,      //
  kCarried,        // boxes: contacts of four points, carried over from the last tick
  kCarriedMore,    //
  kSearched,       // the same, recomputed in every tick
  kBordered,       // border contacts
  kBorderedMore,   //
  kSynchronising,  // free bodies, adopting a snapshot
  kBorderedSynchronising,
  kJoining,  // free bodies, half of which join by a snapshot
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
