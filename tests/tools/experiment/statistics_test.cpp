#include "tools/experiment/statistics.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace tactus::experiment;

TEST_CASE("A quantile is the nearest rank") {
  const std::vector<double> sample{5, 1, 4, 2, 3, 10, 9, 8, 7, 6};
  CHECK(quantile(sample, 0.5) == 5);
  CHECK(quantile(sample, 0.91) == 10);
  CHECK(quantile(sample, 0.01) == 1);
  CHECK(quantile(sample, 1.0) == 10);
  CHECK(quantile({}, 0.5) == 0);
}

TEST_CASE("The median of an even sample is the mean of the middle two") {
  CHECK(median({4, 1, 3, 2}) == 2.5);
  CHECK(median({3, 1, 2}) == 2);
  CHECK(median({}) == 0);
}

TEST_CASE("A gap that hits one of several runs falls out of the minimum by step") {
  const std::vector<std::vector<double>> runs{{10, 900, 10, 10}, {11, 10, 10}, {500, 11, 10, 10}};
  CHECK(minimum_by_step(runs) == std::vector<double>{10, 10, 10});
  CHECK(minimum_by_step({}).empty());
}

TEST_CASE("The exponent of a power law is found") {
  std::vector<double> x, y;
  for (int i = 1; i <= 6; ++i) {
    x.push_back(std::pow(10.0, i));
    y.push_back(0.3 * std::pow(10.0, 1.25 * i));
  }
  CHECK(power_law_exponent(x, y) == Approx(1.25).epsilon(1e-12));
  // What is not positive has no logarithm.
  x.push_back(0);
  y.push_back(7);
  x.push_back(7);
  y.push_back(0);
  CHECK(power_law_exponent(x, y) == Approx(1.25).epsilon(1e-12));
  CHECK(power_law_exponent(std::vector<double>{3, 3}, std::vector<double>{1, 2}) == 0);
}
