#include "rt/calibration/calibration.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "rt/calibration/calibration_worlds.h"
#include "tests/support/physics_bench.h"

using namespace tactus;
using namespace tactus::loop;

namespace {

const CalibrationTimes& measured() {
  static const CalibrationTimes times = time_synthetic_worlds();
  return times;
}

const WorkCounts& counts_of(CalibrationRun run) { return measured()[static_cast<std::uint32_t>(run)].counts; }

// The times that a core of this table would take for the calibration's own runs, each off by at most `noise`.
CalibrationTimes times_of(const CostModel& table, double noise, test::Random& random) {
  CalibrationTimes times = measured();
  for (TimedWork& work : times) work.ns = predict_ns(table, work.counts, work.sub_steps) * random(1 - noise, 1 + noise);
  return times;
}

CostModel random_table(test::Random& random) {
  CostModel table;
  for (const auto term : kCosts) table.*term *= random(0.3, 3);
  return table;
}

WorkCounts heap(std::uint32_t bodies) {
  WorkCounts counts;
  counts.bodies = bodies;
  counts.pairs = 6 * bodies;
  counts.contacts = 3 * bodies;
  counts.points = 9 * bodies;
  counts.comparisons = 2 * bodies;
  counts.border = bodies;
  counts.synchronises = true;
  counts.joins = 2;
  return counts;
}

}  // namespace

TEST_CASE("the calibration's worlds differ by the work that each is for") {
  using Run = CalibrationRun;
  constexpr std::uint32_t n = kCalibrationBodies;
  CHECK(counts_of(Run::kLone).bodies == 1);
  CHECK(counts_of(Run::kFree).bodies == n);
  CHECK(counts_of(Run::kFree).pairs == 0);
  // Rows: each has its two neighbours as pairs.
  for (const Run run : {Run::kApart, Run::kBalls, Run::kCarried, Run::kSearched}) CHECK(counts_of(run).pairs == n - 1);
  CHECK(counts_of(Run::kApart).contacts == 0);
  CHECK(counts_of(Run::kApart).comparisons == 0);
  CHECK(counts_of(Run::kBalls).contacts == n - 1);
  CHECK(counts_of(Run::kBalls).points == n - 1);
  for (const Run run : {Run::kCarried, Run::kSearched}) {
    CHECK(counts_of(run).contacts == n - 1);
    CHECK(counts_of(run).points == 4 * (n - 1));
  }
  CHECK(counts_of(Run::kCarried).comparisons == 0);
  CHECK(counts_of(Run::kSearched).comparisons == n - 1);
  CHECK(counts_of(Run::kBordered).border == 2 * n);
  CHECK(counts_of(Run::kBordered).contacts == 0);
  CHECK(counts_of(Run::kSynchronising).synchronises);
  CHECK(counts_of(Run::kSynchronising).joins == 0);
  CHECK(counts_of(Run::kJoining).joins == n / 2);
  CHECK(counts_of(Run::kJoining).bodies == n);
}

TEST_CASE("the fit finds the table that the times are of") {
  test::Random random(3);
  for (int i = 0; i < 20; ++i) {
    const CostModel table = random_table(random);
    const CostModel found = fit_costs(times_of(table, 0, random));
    for (const auto term : kCosts) CHECK(found.*term == Approx(table.*term).epsilon(1e-9));
  }
}

TEST_CASE("times that are off by three in a hundred move the prediction of a heap by little more") {
  test::Random random(5);
  for (int i = 0; i < 200; ++i) {
    const CostModel table = random_table(random);
    const CostModel found = fit_costs(times_of(table, 0.03, random));
    for (const std::uint32_t bodies : {8u, 32u, 128u}) {
      const double is = predict_ns(table, heap(bodies), 4), says = predict_ns(found, heap(bodies), 4);
      REQUIRE(std::abs(says - is) < 0.08 * is);
    }
  }
}

TEST_CASE("no cost is negative, whatever the clock returned") {
  test::Random random(7);
  for (int i = 0; i < 200; ++i) {
    CalibrationTimes times = measured();
    for (TimedWork& work : times) work.ns = random(0, 1e6);
    const CostModel found = fit_costs(times);
    for (const auto term : kCosts) {
      REQUIRE(found.*term >= 0);
      REQUIRE(std::isfinite(found.*term));
    }
  }
}

// What a core takes is for a benchmark to say: here only that the table can be used, and is held within bounds.
TEST_CASE("a calibration gives a table within its bounds") {
  const CostModel table;
  const Calibration found = calibrate(table);
  CHECK(found.scale >= 0.125);
  CHECK(found.scale <= 64);
  CHECK(found.spread >= 1);
  const WorkCounts& boxes = counts_of(CalibrationRun::kSearched);
  CHECK(predict_ns(found.cost, boxes, 4) == Approx(found.scale * predict_ns(table, boxes, 4)));
  for (const auto term : kCosts) CHECK(found.cost.*term >= 0);
}

TEST_CASE("against a table that no machine can match the costs go as far as the bounds") {
  CostModel table;
  for (const auto term : kCosts) table.*term *= 1e9;
  CHECK(calibrate(table).scale == 0.125);
  for (const auto term : kCosts) table.*term *= 1e-18;
  CHECK(calibrate(table).scale == 64);
}
