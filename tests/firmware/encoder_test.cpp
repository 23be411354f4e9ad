#include "firmware/encoder.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

using namespace tactus::firmware;

TEST_CASE("a count is off its coordinate by at most half a quantum") {
  std::mt19937_64 random(1);
  for (const double quantum : {1e-5, 3.7e-5, 1e-4, 0.01}) {
    std::uniform_real_distribution<double> coordinate(-1.0, 1.0);
    for (int i = 0; i < 20000; ++i) {
      const double x = coordinate(random);
      const double error = coordinate_of(count_of(x, quantum), quantum) - x;
      REQUIRE(std::abs(error) <= 0.5 * quantum * (1.0 + 1e-9));
    }
  }
}

TEST_CASE("a count comes back from its own coordinate") {
  std::mt19937_64 random(2);
  for (int i = 0; i < 20000; ++i) {
    const auto count = static_cast<std::int32_t>(random() % 2000001) - 1000000;
    REQUIRE(count_of(coordinate_of(count, 6e-6), 6e-6) == count);
  }
  CHECK(count_of(-1.4, 1.0) == -1);
  CHECK(count_of(-1.6, 1.0) == -2);
  CHECK(count_of(1.5, 1.0) == 2);
  CHECK(count_of(-1.5, 1.0) == -1);
}

TEST_CASE("coordinates beyond the counter saturate, and NaN is no count") {
  CHECK(count_of(1e30, 1e-5) == kMaxCount);
  CHECK(count_of(-1e30, 1e-5) == -kMaxCount);
  CHECK(count_of(std::numeric_limits<double>::infinity(), 1e-5) == kMaxCount);
  CHECK(count_of(std::numeric_limits<double>::quiet_NaN(), 1e-5) == 0);
}

TEST_CASE("the difference of two counts is right over the counter's wrap") {
  CHECK(count_difference(5, 3) == 2);
  CHECK(count_difference(std::numeric_limits<std::int32_t>::min(), std::numeric_limits<std::int32_t>::max()) == 1);
  CHECK(count_difference(std::numeric_limits<std::int32_t>::max(), std::numeric_limits<std::int32_t>::min()) == -1);
}

TEST_CASE("speed is counts over the device's own time") {
  AxisSpeed speed;
  const std::array<float, kAxes> quantum{1e-5f, 1e-5f, 1e-5f, 1e-4f, 1e-4f, 1e-4f};
  CHECK(speed.update({100, 0, 0, 0, 0, 0}, 1000, 1000, quantum)[0] == 0.0f);  // nothing to compare with
  const auto one_period = speed.update({200, 0, 0, -50, 0, 0}, 2000, 1000, quantum);
  CHECK(one_period[0] == Approx(1.0));
  CHECK(one_period[3] == Approx(-5.0));
  CHECK(speed.update({300, 0, 0, -50, 0, 0}, 12000, 1000, quantum)[0] == Approx(0.1));   // ten periods later
  CHECK(speed.update({301, 0, 0, -50, 0, 0}, 12001, 1000, quantum)[0] == Approx(0.01));  // clock hardly moves
  CHECK(speed.update({302, 0, 0, -50, 0, 0}, 5000, 1000, quantum)[0] == Approx(0.01));   // clock goes back
}
