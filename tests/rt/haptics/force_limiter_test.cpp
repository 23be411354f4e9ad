#include "rt/haptics/force_limiter.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "tests/support/random.h"

using namespace tactus;
using namespace tactus::haptics;
using test::Random;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

ForceLimiter make_limiter() { return {ForceLimiter::Config::of({}, 1e-3), {}}; }  // 30 N, 10 N, 3 N m, 1 N m

// Slew so fast that only the other stages act.
ForceLimiter without_slew() {
  ForceLimiter limiter = make_limiter();
  limiter.config.force.slew_per_s = limiter.config.torque.slew_per_s = 1e300;
  return limiter;
}

}  // namespace

TEST_CASE("a wrench within all limits goes through bit for bit") {
  ForceLimiter limiter = without_slew();
  Random random(31);
  for (int i = 0; i < 1000; ++i) {
    const Wrenchd wanted{random.vector(5), random.vector(0.5)};
    const ForceLimiter::Output out = limiter.limit(wanted, 1, Slew::kNormal);
    REQUIRE(out.wrench == wanted);
    REQUIRE(out.status == 0);
    REQUIRE(out.fault == Fault::kNone);
  }
}

TEST_CASE("whatever comes in, what goes out is finite, within the peaks exactly, and within the slew") {
  const double odd[] = {0,    -0.0,  1e308, -1.7e308, 5e-324, -2e-310, 1e-160,    1e160,
                        30.0, -10.0, 3.0,   1e-300,   29.999, 4.9,     kInfinity, kNaN};
  std::mt19937_64 pick(7);
  Random random(31);
  for (int run = 0; run < 100; ++run) {
    ForceLimiter limiter = make_limiter();
    limiter.state.force.heat = 100.0 * std::abs(random.symmetric());
    Wrenchd wanted, last;
    double last_fade = 1;
    const std::size_t kinds = run % 2 ? 14 : 16;  // every other run without infinity and NaN
    for (int tick = 0; tick < 500; ++tick) {
      const auto number = [&] { return pick() % 3 == 0 ? odd[pick() % kinds] : random.symmetric(100); };
      if (tick == 0 || pick() % 8 == 0) {  // held for some ticks, so that the slew lets it reach the limits
        wanted = {{number(), number(), number()}, {number(), number(), number()}};
      }
      const double fade = pick() % 16 == 0 ? random.symmetric(2) : last_fade;
      const Slew slew = pick() % 4 == 0 ? Slew::kSlow : Slew::kNormal;
      const ForceLimiter::Output out = limiter.limit(wanted, fade, slew);
      REQUIRE(is_finite(out.wrench));
      REQUIRE(norm(out.wrench.force) <= 30.0);
      REQUIRE(norm(out.wrench.torque) <= 3.0);
      REQUIRE((out.fault == Fault::kOutputNotFinite) == !is_finite(wanted));
      if (is_finite(wanted) && std::clamp(fade, 0.0, 1.0) >= std::clamp(last_fade, 0.0, 1.0)) {
        REQUIRE(norm(out.wrench.force - last.force) <= (slew == Slew::kSlow ? 0.2 : 5.0) * (1 + 1e-13));
        REQUIRE(norm(out.wrench.torque - last.torque) <= (slew == Slew::kSlow ? 0.02 : 0.5) * (1 + 1e-13));
      }
      last = out.wrench;
      last_fade = fade;
    }
  }
}

TEST_CASE("saturation keeps the direction, of force and torque apart, up to the largest numbers there are") {
  Random random(31);
  for (const double size : {31.0, 1e3, 1e155, 1e307}) {
    for (int i = 0; i < 200; ++i) {
      ForceLimiter limiter = without_slew();
      const Vec3d direction = normalized_or(random.vector(), Vec3d{1, 0, 0});
      const ForceLimiter::Output out = limiter.limit({direction * size, {0.1, 0, 0}}, 1, Slew::kNormal);
      REQUIRE(norm(out.wrench.force) <= 30.0);
      REQUIRE(norm(out.wrench.force) == Approx(30.0).epsilon(1e-14));
      REQUIRE(norm(out.wrench.force * (1 / 30.0) - direction) < 1e-14);
      REQUIRE(out.wrench.torque == Vec3d{0.1, 0, 0});
      REQUIRE(out.status == kForceSaturated);
    }
  }
  ForceLimiter limiter = without_slew();
  const ForceLimiter::Output out = limiter.limit({{0, 1, 0}, {0, 0, -9}}, 1, Slew::kNormal);
  CHECK(out.wrench.force == Vec3d{0, 1, 0});
  CHECK(out.wrench.torque.z == Approx(-3.0));
}

TEST_CASE("a wrench that is not finite gives zero at once, a fault, and a ramp from zero afterwards") {
  for (const double bad : {kNaN, kInfinity, -kInfinity}) {
    for (int place = 0; place < 6; ++place) {
      ForceLimiter limiter = make_limiter();
      for (int i = 0; i < 10; ++i) limiter.limit({{20, 0, 0}, {0, 2, 0}}, 1, Slew::kNormal);
      Wrenchd wanted{{20, 0, 0}, {0, 2, 0}};
      (place < 3 ? wanted.force : wanted.torque)[place % 3] = bad;
      const ForceLimiter::Output out = limiter.limit(wanted, 1, Slew::kNormal);
      CHECK(out.wrench == Wrenchd{});
      CHECK(out.fault == Fault::kOutputNotFinite);
      CHECK(limiter.limit({{20, 0, 0}, {}}, 1, Slew::kNormal).wrench.force.x == Approx(5.0));
    }
  }
}

TEST_CASE("a step of the wanted force comes out as a ramp of 5 N a tick, or 0.2 N a tick when slow") {
  for (const Slew slew : {Slew::kNormal, Slew::kSlow}) {
    const double step = slew == Slew::kSlow ? 0.2 : 5.0;
    ForceLimiter limiter = make_limiter();
    for (int tick = 1; tick <= 200; ++tick) {
      const ForceLimiter::Output out = limiter.limit({{0, 0, -20}, {}}, 1, slew);
      CHECK(out.wrench.force.z == Approx(-std::min(20.0, step * tick)).epsilon(1e-12));
      if (step * tick < 19.9) CHECK(out.status == kSlewLimited);
      if (step * tick > 20.1) CHECK(out.status == 0);
    }
  }
}

TEST_CASE("the slew limit is per second: at 4 kHz a tick may move a quarter as far") {
  ForceLimiter limiter{ForceLimiter::Config::of({}, 0.25e-3), {}};
  CHECK(limiter.limit({{20, 0, 0}, {}}, 1, Slew::kNormal).wrench.force.x == Approx(1.25));
}

TEST_CASE("a fade to zero is at zero when the fade is, also at the slow slew, and never grows the force") {
  for (const Slew slew : {Slew::kNormal, Slew::kSlow}) {
    ForceLimiter limiter = make_limiter();
    const Wrenchd wanted{{0, 30, 0}, {3, 0, 0}};
    for (int i = 0; i < 300; ++i) limiter.limit(wanted, 1, Slew::kNormal);
    double last = 30;
    for (int missed = 1; missed <= 10; ++missed) {
      const ForceLimiter::Output out = limiter.limit(wanted, 1 - missed / 10.0, slew);
      const double force = norm(out.wrench.force);
      CHECK(force == Approx(30 * (1 - missed / 10.0)).margin(1e-9));
      CHECK(force < last);
      last = force;
    }
    CHECK(limiter.limit(wanted, 0, slew).wrench == Wrenchd{});
    // Back again: under the slew.
    CHECK(norm(limiter.limit(wanted, 1, slew).wrench.force) <= (slew == Slew::kSlow ? 0.2 : 5.0) * (1 + 1e-13));
  }
}

TEST_CASE("a fade that is no number is a fade to zero, one above 1 is none") {
  ForceLimiter limiter = without_slew();
  CHECK(limiter.limit({{9, 0, 0}, {}}, 7, Slew::kNormal).wrench.force.x == 9);
  CHECK(limiter.limit({{9, 0, 0}, {}}, kNaN, Slew::kNormal).wrench == Wrenchd{});
  CHECK(limiter.limit({{9, 0, 0}, {}}, -1, Slew::kNormal).wrench == Wrenchd{});
}

TEST_CASE("three times the continuous force from cold is whole for tau ln(18/17) and then comes down to continuous") {
  ForceLimiter limiter = without_slew();
  const double begins_s = 30.0 * std::log(18.0 / 17.0);  // heat 900 (1 - exp(-t / 30)) reaches 50
  int first_cut = 0;
  for (int tick = 1; tick <= 120'000; ++tick) {
    const ForceLimiter::Output out = limiter.limit({{30 * (1 - 1e-14), 0, 0}, {}}, 1, Slew::kNormal);
    if (first_cut == 0 && (out.status & kForceSaturated) != 0) first_cut = tick;
    if (tick == 120'000) CHECK(norm(out.wrench.force) == Approx(10.0).epsilon(1e-3));
  }
  CHECK(first_cut * 1e-3 == Approx(begins_s).margin(0.01));
  CHECK(limiter.torque_limit_Nm() == 3.0);
  for (int tick = 0; tick < 30'000; ++tick) limiter.limit({}, 1, Slew::kNormal);  // one tau of rest: heat 37 of 100
  CHECK(limiter.force_limit_N() == 30.0);
}

TEST_CASE("the mean square over tau never passes the continuous rating's, and a force within it is never cut") {
  Random random(31);
  ForceLimiter limiter = make_limiter();
  limiter.config.thermal_time_s = 0.5;  // faster than any motor, so that the test sees many warm and cool times
  double mean_square = 0;
  bool was_warm = false;
  Vec3d wanted;
  for (int tick = 0; tick < 200'000; ++tick) {
    if (tick % 50 == 0) wanted = random.vector((tick / 2000) % 2 ? 60 : 4);
    const ForceLimiter::Output out = limiter.limit({wanted, {}}, 1, Slew::kNormal);
    mean_square += (norm_squared(out.wrench.force) - mean_square) * (1e-3 / 0.5);
    REQUIRE(mean_square <= 100.0 * (1 + 1e-12));
    REQUIRE(limiter.force_limit_N() >= 10.0 * (1 - 1e-12));
    was_warm = was_warm || mean_square > 90;
  }
  CHECK(was_warm);
  ForceLimiter steady = make_limiter();
  for (int tick = 0; tick < 300'000; ++tick) {
    REQUIRE((steady.limit({{0, 9.999, 0}, {}}, 1, Slew::kNormal).status & kForceSaturated) == 0);
  }
}
