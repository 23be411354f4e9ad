#include "firmware/thermal.h"

#include <cmath>
#include <limits>

#include "tests/firmware/device_bench.h"

using namespace tactus::firmware;

namespace {

ThermalConfig motor(float gain, float time_constant_s, float warning_K, float limit_K) {
  ThermalConfig c;
  c.gain_K_per_effort2.fill(gain);
  c.time_constant_s.fill(time_constant_s);
  c.warning_K.fill(warning_K);
  c.limit_K.fill(limit_K);
  return c;
}

void run(ThermalModel& model, float effort, int periods, float measured_K = 0) {
  AxisValues efforts, measured;
  efforts.fill(effort);
  measured.fill(measured_K);
  for (int i = 0; i < periods; ++i) model.update(efforts, measured, 1000);
}

}  // namespace

TEST_CASE("a constant effort warms a winding as a first-order system does, sign no matter") {
  for (const float effort : {3.0f, -3.0f})
    for (const double time_constant_s : {1.0, 10.0, 1000.0}) {
      ThermalModel model;
      model.configure(motor(2.0f, static_cast<float>(time_constant_s), 500, 600));
      for (int piece = 1; piece <= 4; ++piece) {
        const int periods = static_cast<int>(time_constant_s > 100 ? 200000 : time_constant_s * 1000) / 64 * 64;
        run(model, effort, periods);
        const double end_K = 18.0 * (1.0 - std::exp(-piece * periods * 1e-3 / time_constant_s));
        // The implicit step lags by half a step of 64 ms; float loses far less.
        const double step = 0.064 / time_constant_s;
        REQUIRE(std::abs(static_cast<double>(model.rise_K()[0]) - end_K) < 18.0 * step + 0.02);
      }
    }
}

TEST_CASE("it is the mean square of the effort that warms, and no effort cools back to ambient") {
  ThermalModel steady, pulsed;
  steady.configure(motor(1, 5, 500, 600));
  pulsed.configure(motor(1, 5, 500, 600));
  for (int i = 0; i < 6400; ++i) {
    run(steady, 2.0f, 1);
    run(pulsed, i % 4 == 0 ? 4.0f : 0.0f, 1);
  }
  CHECK(pulsed.rise_K()[3] == Approx(steady.rise_K()[3]));
  run(steady, 0, 64000);
  CHECK(steady.rise_K()[0] < 1e-4f);
}

TEST_CASE("above the warning the share falls linearly to zero at the limit, and there it is a fault") {
  for (int rise = 0; rise <= 120; rise += 5) {
    ThermalModel model;
    model.configure(motor(1, 1e6f, 60, 100));
    run(model, 0, 64, static_cast<float>(rise));  // a sensor tells
    const float share = rise <= 60 ? 1.0f : rise >= 100 ? 0.0f : static_cast<float>(100 - rise) / 40.0f;
    CHECK(model.effort_share()[0] == Approx(share).margin(1e-4));
    CHECK(model.is_warm() == (rise > 60));
    CHECK(model.is_too_hot() == (rise >= 100));
    CHECK(model.hot_axis() == (rise >= 100 ? 0u : kAxes));
  }
}

TEST_CASE("a motor without a limit has no model, whatever the others have") {
  ThermalConfig c = motor(1e6f, 1, 10, 20);
  c.limit_K[2] = 0;
  ThermalModel model;
  model.configure(c);
  run(model, 10, 640, 900);
  CHECK(model.effort_share()[2] == 1.0f);
  CHECK(model.rise_K()[2] == 0.0f);
  CHECK(model.effort_share()[1] == 0.0f);
}

TEST_CASE("which thermal parameters make sense") {
  CHECK(is_valid(ThermalConfig{}));
  CHECK(is_valid(motor(1, 10, 60, 100)));
  CHECK_FALSE(is_valid(motor(1, 10, 100, 100)));
  CHECK_FALSE(is_valid(motor(1, 10, 0, 100)));
  CHECK_FALSE(is_valid(motor(1, 0, 60, 100)));
}

TEST_CASE("a motor that is driven hard settles where its effort makes its temperature, without a step") {
  DeviceConfig config = bench_config();
  config.thermal = motor(0, 2.0f, 40, 80);
  config.thermal.gain_K_per_effort2[0] = 1.0f;  // at 10 N it would end at 100 K
  DeviceBench b(config);
  b.start_force({10, 0, 0, 0, 0, 0});
  float before = b.outputs.effort[0];
  for (int i = 0; i < 20000; ++i) {
    b.command(State::kForce, {10, 0, 0, 0, 0, 0});
    REQUIRE(b.state() == State::kForce);
    REQUIRE(std::abs(b.outputs.effort[0] - before) <= 10.0f * 100.0f / 40.0f * 0.064f / 2.0f);
    before = b.outputs.effort[0];
  }
  // rise = u^2 and u = 10 (80 - rise) / 40: u^2 + 4 u - 80 = 0, u = -2 + sqrt 84.
  CHECK(b.outputs.effort[0] == Approx(-2.0 + std::sqrt(84.0)).epsilon(1e-3));
  CHECK(b.limited(Limit::kWarm));
  CHECK(b.read_real(number::kWindingRise) == Approx(std::pow(std::sqrt(84.0) - 2.0, 2)).epsilon(2e-3));
  CHECK(b.read_real(number::kEffortShare) == Approx((std::sqrt(84.0) - 2.0) / 10.0).epsilon(2e-3));
}

TEST_CASE("a winding that a sensor finds at its limit brakes, and may be re-armed once it has cooled") {
  DeviceConfig config = bench_config();
  config.thermal = motor(1, 1.0f, 40, 80);
  DeviceBench b(config);
  b.start_force({1, 0, 0, 0, 0, 0});
  b.inputs.measured_rise_K[4] = 95;
  int periods = 0;
  while (b.state() == State::kForce && periods < 1000) {
    b.command(State::kForce);
    ++periods;
  }
  CHECK(periods <= static_cast<int>(kThermalPeriods) + 1);
  CHECK(b.fault() == Fault::kOverheated);
  CHECK(b.device.fault_log().entry(0).axis == 4);
  CHECK(b.device.fault_log().entry(0).value == 95.0f);
  b.rearm();
  CHECK(b.state() == State::kBrake);
  b.inputs.measured_rise_K[4] = 0;
  for (int i = 0; i < 1000; ++i) b.command(State::kIdle);
  b.rearm();
  CHECK(b.state() == State::kIdle);
}

TEST_CASE("an infinite sensor value brakes, and the model recovers when the sensor does") {
  ThermalModel model;
  model.configure(motor(1, 1.0f, 40, 80));
  run(model, 0, 64, std::numeric_limits<float>::infinity());
  CHECK(model.is_too_hot());
  CHECK(model.effort_share()[0] == 0.0f);
  run(model, 0, 64 * 100);  // 1000 K, six time constants ago: 1.7 K
  CHECK_FALSE(model.is_too_hot());
  CHECK(model.rise_K()[0] < 5.0f);
  run(model, 0, 64, std::numeric_limits<float>::quiet_NaN());
  CHECK(model.rise_K()[0] < 5.0f);
}
