#include "rt/calibration/calibration.h"

#include <algorithm>
#include <vector>

#include "rt/base/clock.h"
#include "rt/calibration/calibration_worlds.h"

namespace tactus::loop {
namespace {

// Few and many sub-steps: their difference must exceed the noise.
constexpr std::uint32_t kFew = 1, kMany = 6;
// Warm-up rounds without measurement (caches, branch predictors), minimum and maximum of measured rounds.
constexpr std::uint32_t kWarmRounds = 3, kMinRounds = 9, kMaxRounds = 151;
constexpr std::int64_t kTimeForRounds_ns = 200'000'000;

// Ticks after a sleep, like those of a loop at 1 kHz that finishes early.
constexpr std::uint32_t kSleeps = 80, kUsualSubSteps = 4;
constexpr std::int64_t kSleep_ns = 900'000;

// One round executes every run once.
class Rounds {
 public:
  CalibrationTimes operator()() {
    return {lone_.tick(kFew),
            free_.tick(kFew),
            free_.tick(kMany),
            apart_.tick(kFew),
            balls_.tick(kFew),
            balls_.tick(kMany),
            carried_.tick(kFew),
            carried_.tick(kMany),
            searched_.tick(kFew),
            bordered_.tick(kFew),
            bordered_.tick(kMany),
            free_.tick_synchronising(kFew),
            bordered_.tick_synchronising(kFew),
            free_.tick_joining(kFew)};
  }

 private:
  using Kind = SyntheticWorld;
  CalibrationWorld lone_{Kind::kLone}, free_{Kind::kFree}, apart_{Kind::kApart}, balls_{Kind::kBalls},
      carried_{Kind::kCarried}, searched_{Kind::kSearched}, bordered_{Kind::kBordered};
};

double percentile(std::vector<double>& times, double share) {
  const auto at = times.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(times.size() - 1));
  std::nth_element(times.begin(), at, times.end());
  return *at;
}

// Times of ticks after a sleep: the proxy alone, and boxes in contact.
struct Woken {
  TimedWork lone, boxes;  // p90
  double spread;          // p90 / median of the boxes
};

Woken time_after_sleeps() {
  CalibrationWorld lone(SyntheticWorld::kLone), boxes(SyntheticWorld::kSearched);
  Woken result;
  std::vector<double> lone_times, boxes_times;
  for (std::uint32_t i = 0; i < kSleeps; ++i) {
    MonotonicClock::sleep_until_ns(MonotonicClock::now_ns() + kSleep_ns);
    lone_times.push_back((result.lone = lone.tick(kUsualSubSteps)).ns);
    MonotonicClock::sleep_until_ns(MonotonicClock::now_ns() + kSleep_ns);
    boxes_times.push_back((result.boxes = boxes.tick(kUsualSubSteps)).ns);
  }
  result.lone.ns = percentile(lone_times, 0.9);
  result.boxes.ns = percentile(boxes_times, 0.9);
  result.spread = result.boxes.ns / percentile(boxes_times, 0.5);
  return result;
}

double predict_ns(const CostModel& cost, const TimedWork& work) {
  return loop::predict_ns(cost, work.counts, work.sub_steps);
}

}  // namespace

CalibrationTimes time_synthetic_worlds() {
  Rounds round;
  for (std::uint32_t i = 0; i < kWarmRounds; ++i) (void)round();
  CalibrationTimes result{};
  std::array<std::vector<double>, kCalibrationRuns> times;
  const std::int64_t until_ns = MonotonicClock::now_ns() + kTimeForRounds_ns;
  for (std::uint32_t i = 0; i < kMaxRounds; ++i) {
    if (i >= kMinRounds && MonotonicClock::now_ns() > until_ns) break;
    result = round();
    for (std::uint32_t run = 0; run < kCalibrationRuns; ++run) times[run].push_back(result[run].ns);
  }
  for (std::uint32_t run = 0; run < kCalibrationRuns; ++run) result[run].ns = percentile(times[run], 0.5);
  return result;
}

void work_beside(const std::atomic<bool>& stop) {
  CalibrationWorld world(SyntheticWorld::kSearched);
  while (!stop.load(std::memory_order_relaxed)) (void)world.tick(kMany);
}

// The proxy alone gives the fixed cost; the boxes give the factor on the other costs after a sleep, relative to
// consecutive ticks.
Calibration calibrate(const CostModel& table, double safety) {
  CostModel cost = fit_costs(time_synthetic_worlds());
  const Woken woken = time_after_sleeps();
  cost.fixed += std::max(0.0, woken.lone.ns - predict_ns(cost, woken.lone));
  const double rest_ns = predict_ns(cost, woken.boxes) - cost.fixed;
  const double colder = std::max(1.0, (woken.boxes.ns - cost.fixed) / rest_ns);
  const double measured_ns = cost.fixed + colder * rest_ns, by_table_ns = predict_ns(table, woken.boxes);

  Calibration result;
  result.spread = woken.spread;
  result.scale = std::clamp(safety * measured_ns / by_table_ns, 0.125, 64.0);
  const double factor = result.scale * by_table_ns / measured_ns;
  for (const auto term : kCosts) result.cost.*term = (term == &CostModel::fixed ? 1.0 : colder) * factor * cost.*term;
  return result;
}

}  // namespace tactus::loop
