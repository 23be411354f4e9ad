#include "firmware/gravity.h"

#include <cmath>
#include <limits>
#include <random>

#include "firmware/sine.h"
#include "tests/firmware/device_bench.h"

using namespace tactus::firmware;

TEST_CASE("sine and cosine are right to 2e-7 up to 8192 rad, and nothing beyond") {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<float> small(-4.0f, 4.0f), large(-8192.0f, 8192.0f);
  for (int i = 0; i < 100000; ++i) {
    const float x = i % 2 == 0 ? small(random) : large(random);
    const SineCosine f = sine_cosine(x);
    REQUIRE(std::abs(static_cast<double>(f.sine) - std::sin(static_cast<double>(x))) < 2e-7);
    REQUIRE(std::abs(static_cast<double>(f.cosine) - std::cos(static_cast<double>(x))) < 2e-7);
  }
  for (const float x :
       {8193.0f, -1e30f, std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()}) {
    CHECK(sine_cosine(x).sine == 0.0f);
    CHECK(sine_cosine(x).cosine == 0.0f);
  }
}

TEST_CASE("a combination holds six integers from -8 to 7 and the choice of function") {
  std::mt19937_64 random(2);
  for (int i = 0; i < 1000; ++i) {
    std::array<std::int32_t, kAxes> factors{};
    for (auto& f : factors) f = static_cast<std::int32_t>(random() % 16) - 8;
    const bool cosine = random() % 2 == 0;
    const std::uint32_t combination = make_combination(factors, cosine);
    REQUIRE(combination <= kMaxCombination);
    REQUIRE(((combination & kCosineTerm) != 0) == cosine);
    for (unsigned k = 0; k < kAxes; ++k) REQUIRE(combination_factor(combination, k) == factors[k]);
  }
}

TEST_CASE("the terms carry a chain of links as the slope of its potential energy says") {
  // Three links in a vertical plane on axes 3, 4, 5; angles from the horizontal add up.
  constexpr double kG = 9.81, l1 = 0.3, l2 = 0.25, c1 = 0.15, c2 = 0.1, c3 = 0.05, m1 = 0.5, m2 = 0.3, m3 = 0.2;
  const auto potential_J = [](double a, double b, double c) {
    const double y1 = c1 * std::sin(a), y2 = l1 * std::sin(a) + c2 * std::sin(a + b);
    const double y3 = l1 * std::sin(a) + l2 * std::sin(a + b) + c3 * std::sin(a + b + c);
    return kG * (m1 * y1 + m2 * y2 + m3 * y3);
  };
  const std::array<double, 3> torque{kG * (m1 * c1 + (m2 + m3) * l1), kG * (m2 * c2 + m3 * l2), kG * m3 * c3};
  const std::array<std::uint32_t, 3> sums{make_combination({0, 0, 0, 1, 0, 0}, true),
                                          make_combination({0, 0, 0, 1, 1, 0}, true),
                                          make_combination({0, 0, 0, 1, 1, 1}, true)};
  GravityConfig config;
  for (unsigned axis = 0; axis < 3; ++axis)
    for (unsigned link = axis; link < 3; ++link) {
      config.amplitude[kGravityTerms * (3 + axis) + link] = static_cast<float>(torque[link]);
      config.combination[kGravityTerms * (3 + axis) + link] = sums[link];
    }
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> angle(-3.0, 3.0);
  for (int i = 0; i < 2000; ++i) {
    const double a = angle(random), b = angle(random), c = angle(random), h = 1e-5;
    const AxisValues q{0, 0, 0, static_cast<float>(a), static_cast<float>(b), static_cast<float>(c)};
    const AxisValues effort = gravity_effort(config, q);
    const std::array<double, 3> slope{(potential_J(a + h, b, c) - potential_J(a - h, b, c)) / (2 * h),
                                      (potential_J(a, b + h, c) - potential_J(a, b - h, c)) / (2 * h),
                                      (potential_J(a, b, c + h) - potential_J(a, b, c - h)) / (2 * h)};
    for (unsigned axis = 0; axis < 3; ++axis) {
      REQUIRE(effort[axis] == 0.0f);
      REQUIRE(static_cast<double>(effort[3 + axis]) == Approx(slope[axis]).margin(2e-5));
    }
  }
}

TEST_CASE("every term is its amplitude times the function of its own sum of angles") {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<float> amplitude(-2.0f, 2.0f), angle(-1.0f, 1.0f);
  for (int i = 0; i < 500; ++i) {
    GravityConfig config;
    AxisValues q{};
    for (float& x : q) x = angle(random);
    std::array<double, kAxes> expected{};
    for (unsigned axis = 0; axis < kAxes; ++axis) {
      config.constant[axis] = amplitude(random);
      expected[axis] = static_cast<double>(config.constant[axis]);
      for (unsigned k = 0; k < kGravityTerms; ++k) {
        std::array<std::int32_t, kAxes> factors{};
        double sum = 0;
        for (unsigned j = 0; j < kAxes; ++j) {
          factors[j] = static_cast<std::int32_t>(random() % 16) - 8;
          sum += static_cast<double>(factors[j]) * static_cast<double>(q[j]);
        }
        const bool cosine = random() % 2 == 0;
        const unsigned term = kGravityTerms * axis + k;
        config.amplitude[term] = amplitude(random);
        config.combination[term] = make_combination(factors, cosine);
        expected[axis] += static_cast<double>(config.amplitude[term]) * (cosine ? std::cos(sum) : std::sin(sum));
      }
    }
    const AxisValues effort = gravity_effort(config, q);
    for (unsigned axis = 0; axis < kAxes; ++axis)
      REQUIRE(static_cast<double>(effort[axis]) == Approx(expected[axis]).margin(1e-4));
  }
}

TEST_CASE("what the terms cost and give is nothing by default") {
  CHECK(gravity_effort(GravityConfig{}, {1, 2, 3, 4, 5, 6}) == AxisValues{});
}

TEST_CASE("support and command stay within motor and norm, the support is kept and the command's direction too") {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<float> force(-20.0f, 20.0f), weight(-4.0f, 4.0f);
  const Config config = bench_config().control;
  Controller controller(config);
  ControllerInputs inputs;
  unsigned scaled = 0;
  for (std::uint32_t i = 1; i < 30000; ++i) {
    CommandFrame command{
        i == 1 ? State::kIdle : State::kForce, false, i, {force(random), force(random), force(random), 0, 0, 0}};
    Supervision s;
    s.support = {weight(random), weight(random), weight(random), 0, 0, 0};
    std::array<std::byte, kCommandFrameSize> bytes{};
    encode_command(command, bytes);
    inputs.time_us += 1000;
    const auto outputs = controller.step(inputs, bytes, s);
    if (controller.state() != State::kForce) continue;
    double norm2 = 0, along = 0, command2 = 0, more2 = 0;
    bool more_breaks = false;
    std::array<double, 3> given{};
    for (unsigned k = 0; k < 3; ++k) {
      REQUIRE(std::abs(outputs.effort[k]) <= 10.0f);
      norm2 += std::pow(static_cast<double>(outputs.effort[k]), 2);
      given[k] = static_cast<double>(outputs.effort[k]) - static_cast<double>(s.support[k]);
      along += given[k] * static_cast<double>(command.effort[k]);
      command2 += std::pow(static_cast<double>(command.effort[k]), 2);
    }
    REQUIRE(std::sqrt(norm2) <= 12.0 * (1 + 1e-6));
    const double share = along / command2;
    REQUIRE(share > -1e-6);
    REQUIRE(share < 1 + 1e-6);
    for (unsigned k = 0; k < 3; ++k) {
      const auto c = static_cast<double>(command.effort[k]);
      REQUIRE(given[k] == Approx(share * c).margin(2e-5));
      const double more = static_cast<double>(s.support[k]) + (share + 1e-3) * c;
      more_breaks = more_breaks || std::abs(more) > 10.0;
      more2 += more * more;
    }
    // No more would have fitted.
    if (share < 0.999) {
      REQUIRE((more_breaks || more2 > 144.0));
      ++scaled;
    }
  }
  CHECK(scaled > 10000);
}

TEST_CASE("a support beyond the motors is cut like a command") {
  Controller controller(bench_config().control);
  ControllerInputs inputs;
  Supervision s;
  s.support = {300, 0, 0, 0, 0, 30};
  s.support_in_idle = true;
  controller.step(inputs, {}, s);
  const auto outputs = controller.step(inputs, {}, s);
  CHECK(outputs.effort == AxisValues{10, 0, 0, 0, 0, 1});
  CHECK((controller.limits() & axis_limit_bit(0)) != 0);
}

TEST_CASE("while commands are missing the command fades and the support stays until BRAKE") {
  DeviceConfig config = bench_config();
  config.gravity.constant = {0, 0, 3, 0, 0, 0};
  for (int missed = 0; missed <= 11; ++missed) {
    DeviceBench b(config);
    b.start_force({0, 0, 4, 0, 0, 0});
    b.nothing(missed);
    const float share = missed < 3 ? 1.0f : static_cast<float>(10 - missed) / 8.0f;
    CHECK(b.outputs.effort[2] == Approx(missed >= 10 ? 0.0f : 3.0f + 4.0f * share));
  }
}

TEST_CASE("the arm's weight is carried in FORCE, in IDLE only if configured, and never from an unknown position") {
  for (const bool in_idle : {false, true})
    for (const bool demanded : {false, true}) {
      DeviceConfig config = bench_config();
      config.gravity.amplitude[4 * 4] = 0.5f;
      config.gravity.combination[4 * 4] = make_combination({0, 0, 0, 0, 1, 0}, true);
      config.gravity.in_idle = in_idle ? 1 : 0;
      config.encoders.homing_demanded = demanded ? 1 : 0;
      config.encoders.cradle_position[4] = 7000;  // 0.7 rad
      DeviceBench b(config);
      b.inputs.counts[4] = 7000;
      b.start_force();
      CHECK(b.state() == (demanded ? State::kIdle : State::kForce));
      const float carried = 0.5f * std::cos(0.7f);
      CHECK(b.outputs.effort[4] == Approx(demanded ? 0.0f : carried));
      REQUIRE(b.execute(number::kHome, 2) == (demanded ? ServiceStatus::kGood : ServiceStatus::kWrongState));
      b.command(State::kIdle);
      CHECK(b.outputs.effort[4] == Approx(in_idle ? carried : 0.0f));
      b.command(State::kBrake);
      CHECK(b.outputs.effort[4] == 0.0f);
    }
}
