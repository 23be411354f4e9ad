#include "firmware/speed_filter.h"

#include <cmath>

#include "tests/firmware/device_bench.h"

using namespace tactus::firmware;

TEST_CASE("a step in speed comes through as a first-order filter of its corner says") {
  SpeedFilter filter;
  const float corner_Hz = 50.0f;
  const double w = 2 * 3.14159265358979 * 50.0 * 1e-3;
  for (int k = 1; k <= 40; ++k) {
    filter.update({1, 0, 0, -2, 0, 0}, corner_Hz, 1000);
    const double through = 1.0 - std::pow(1.0 + w, -k);  // implicit Euler of v' = (1 - v) w / T
    REQUIRE(static_cast<double>(filter.speed()[0]) == Approx(through).epsilon(1e-4));
    REQUIRE(static_cast<double>(filter.speed()[3]) == Approx(-2 * through).epsilon(1e-4));
  }
}

TEST_CASE("a ramp lags by the stated latency of the filter") {
  SpeedFilter filter;
  float ramp = 0;
  for (int k = 0; k < 2000; ++k) {
    ramp = 0.001f * static_cast<float>(k);
    filter.update({ramp}, 50.0f, 1000);
  }
  const double lag_s = static_cast<double>(ramp - filter.speed()[0]);  // the ramp rises by 1 per second
  CHECK(lag_s == Approx(1.0 / (2 * 3.14159265358979 * 50.0)).epsilon(0.01));
}

TEST_CASE("without a corner the speed is the difference itself") {
  SpeedFilter filter;
  filter.update({1e8f, 0, 0, 0, 0, 0}, 0, 1000);  // nothing of it is left, not even by rounding
  filter.update({3, 0, 0, 0, 0, 0}, 0, 1000);
  CHECK(filter.speed()[0] == 3.0f);
}

TEST_CASE("a filtered speed delays no overspeed") {
  DeviceConfig config = bench_config();
  config.encoders.speed_corner_Hz = 1;
  DeviceBench b(config);
  b.start_force();
  b.inputs.counts[0] += 201;  // 2.01 m/s in one period
  b.command(State::kForce);
  CHECK(b.state() == State::kBrake);
  CHECK(b.fault() == Fault::kOverspeed);
  CHECK(b.read_real(number::kSpeed) < 0.1f);
}
