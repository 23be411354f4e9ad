#include "tools/experiment/coupling/capacity.h"

#include <catch2/catch.hpp>

using namespace tactus::experiment;

TEST_CASE("The capacity is found to a factor of 2^(1/8)") {
  for (const unsigned truth : {30u, 100u, 333u, 2000u, 7777u}) {
    const Bracket found = find_capacity(25, 20000, [truth](unsigned bodies) { return bodies <= truth; });
    CHECK(found.fits <= truth);
    CHECK(found.too_many > truth);
    CHECK(found.too_many < 1.1 * found.fits);
  }
}

TEST_CASE("A capacity below the smallest heap is none, one beyond the largest has no upper end") {
  CHECK(find_capacity(25, 1000, [](unsigned) { return false; }).fits == 0);
  const Bracket all = find_capacity(25, 1000, [](unsigned) { return true; });
  CHECK(all.fits == 800);
  CHECK(all.too_many == 0);
}

TEST_CASE("Every heap that is timed is there, with its contacts and its budget", "[threads]") {
  CapacityRequest request;
  request.rates_Hz = {1000};
  request.ratios = {10};
  request.couplings = {tactus::experiment::kDirectScheme, {}};
  request.most_bodies = 25;
  request.ticks = 10;
  const auto report = run_capacity(request, {});
  REQUIRE(report.ok());
  REQUIRE(report.value().points.size() == 2);
  for (const CapacityPoint& point : report.value().points) {
    CHECK(point.bodies == 25);
    CHECK(point.contact_points >= 4 * 25 / 2);  // what lies on something has four, and is under something at most
    CHECK(point.tick_us_p50 <= point.tick_us_p99);
  }
  CHECK(report.value().points[0].step_us_p90 == 0);
  CHECK(report.value().points[1].step_us_p90 > 0);
}
