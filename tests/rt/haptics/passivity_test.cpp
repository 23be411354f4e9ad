#include "rt/haptics/passivity.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "tests/support/bits.h"

using namespace tactus;
using namespace tactus::haptics;
using test::same_bits;

namespace {

constexpr double kT = 1e-3, kMass = 0.3;

Passivity make_port(double delay_ticks = 0) {  // alpha_max 5.5 N s/m
  DeviceProperties device;
  device.delay_s = delay_ticks * kT;
  return {Passivity::Config::of(device, {}, kT), {}};
}

// A hand's mass without any damping of its own, moved exactly by forces that are held over a tick.
struct Hand {
  Vec3d x, v;
  Vec3d mean_velocity;  // over the last tick: the pose's backward difference
  double work_J{0};     // that it got from the device
  void move(const Vec3d& force) {
    const Vec3d step = v * kT + force * (0.5 * kT * kT / kMass);
    x += step;
    v += force * (kT / kMass);
    mean_velocity = step * (1 / kT);
    work_J += dot(force, step);
  }
  double kinetic_J() const { return 0.5 * kMass * norm_squared(v); }
};

Vec3d random_direction(std::mt19937_64& random) {
  std::uniform_real_distribution<double> u(-1, 1);
  return normalized_or(Vec3d{u(random), u(random), u(random)}, Vec3d{1, 0, 0});
}

// A chain of one port and the hand on it.
struct Chain {
  Passivity port = make_port();
  Hand hand;
  bool controlled{true};
  double top_work_J{0}, top_speed{0};
  void tick(const Vec3d& wanted) {
    Wrenchd sent{wanted, {}};
    if (controlled) sent = port.control(sent, {hand.mean_velocity, {}});
    port.record_sent(sent);
    hand.move(sent.force);
    top_work_J = std::max(top_work_J, hand.work_J);
    top_speed = std::max(top_speed, norm(hand.v));
  }
};

// A virtual spring and damper on a wall x > 0, and the energy that it stores.
struct Wall {
  double stiffness{2000}, damping{5};
  double force(double x, double v) const { return x > 0 ? std::min(0.0, -stiffness * x - damping * v) : 0.0; }
  double stored_J(double x) const { return x > 0 ? 0.5 * stiffness * x * x : 0.0; }
};

}  // namespace

TEST_CASE("negative damping gives the hand no more than the energy of two ticks") {
  std::mt19937_64 random(1);
  for (const double c : {0.5, 2.0, 5.0}) {
    Chain with, without;
    without.controlled = false;
    with.hand.v = without.hand.v = random_direction(random) * 0.05;
    for (int k = 0; k < 2000; ++k) {
      with.tick(with.hand.mean_velocity * c);
      without.tick(without.hand.mean_velocity * c);
      REQUIRE(with.port.state.translation.alpha <= with.port.config.translation.max_damping);
    }
    CHECK(with.top_work_J <= 2 * kT * c * with.top_speed * with.top_speed);
    CHECK(without.top_work_J > 10 * with.top_work_J);
  }
}

TEST_CASE("a delayed spring gives the hand no more than the debt, where without control it runs away") {
  std::mt19937_64 random(2);
  for (int run = 0; run < 50; ++run) {
    // A delay of one tick and the hold are worth a negative damping of K (T + T/2) = 0.9 to 3 N s/m.
    const double stiffness = 600.0 + 28.0 * run;
    Chain with, without;
    without.controlled = false;
    with.hand.v = without.hand.v = random_direction(random) * 0.3;
    Vec3d x_with, x_without;
    for (int k = 0; k < 3000; ++k) {
      const Vec3d late_with = x_with, late_without = x_without;
      x_with = with.hand.x;
      x_without = without.hand.x;
      with.tick(late_with * -stiffness);
      without.tick(late_without * -stiffness);
    }
    CHECK(with.top_work_J <= with.port.config.translation.debt_cap_J);
    CHECK(with.port.state.translation.forgiven_J == 0);
    CHECK(without.top_work_J > 1.0);
  }
}

TEST_CASE("a passive wall is untouched, bit for bit, at any depth that its coupling declares") {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> u(0, 1);
  const Wall wall;
  double deepest_J = 0;
  for (int run = 0; run < 20; ++run) {
    Passivity port = make_port();
    const double amplitude = 0.015 * u(random), centre = amplitude * u(random), rate = 2 + 8 * u(random);
    double x = centre - amplitude;  // outside
    for (int k = 0; k < 5000; ++k) {
      const double next = centre - amplitude * std::cos(rate * kT * k);
      const double v = (next - x) / kT;
      x = next;
      const Wrenchd wanted{{wall.force(x, v), 0, -0.0}, {0, 0, 0}};
      const Wrenchd out = port.control(wanted, {{v, 0, -0.1}, {}}, {wall.stored_J(x), 0});
      REQUIRE(same_bits(out, wanted));
      REQUIRE(port.status() == 0);
      port.record_sent(out);
      deepest_J = std::max(deepest_J, wall.stored_J(x));
    }
    CHECK(port.state.translation.dropped_J < port.state.translation.in_J);
  }
  CHECK(deepest_J > 5 * make_port().config.translation.energy_cap_J);
}

TEST_CASE("energy beyond the cap that no spring declares is dropped and counted") {
  Passivity port = make_port();
  for (int k = 0; k < 100; ++k) {
    port.control({}, {{1, 0, 0}, {}});
    port.record_sent({{-10, 0, 0}, {}});  // 10 mJ a tick into the virtual side
  }
  port.control({}, {{1, 0, 0}, {}});
  CHECK(port.state.translation.energy_J == port.config.translation.energy_cap_J);
  CHECK(port.state.translation.in_J == Approx(1.0));
  CHECK(port.state.translation.dropped_J == Approx(0.95));
}

TEST_CASE("an hour of dissipation hides no more than the cap of later activity") {
  Chain chain;
  for (int k = 0; k < 20'000; ++k) {  // a hand that stirs in a viscous world
    chain.hand.v = {0.3 * std::sin(0.02 * k), 0.3 * std::cos(0.02 * k), 0};
    chain.tick(chain.hand.mean_velocity * -5.0);
  }
  chain.hand = {};
  chain.hand.v = {0.05, 0, 0};
  for (int k = 0; k < 5000; ++k) chain.tick(chain.hand.mean_velocity * 4.0);
  const double two_ticks_J = 2 * kT * 4.0 * chain.top_speed * chain.top_speed;
  CHECK(chain.hand.work_J <= chain.port.config.translation.energy_cap_J + two_ticks_J);
}

TEST_CASE("the energy balance closes, and energy given minus forgiven is never beyond the debt") {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> u(-1, 1);
  Passivity port = make_port();
  double exchanged = 0;
  Vec3d sent;
  for (int k = 0; k < 100'000; ++k) {
    const double bias = (k / 5000) % 2 ? 0.5 : -0.5;  // now active, now passive
    const Vec3d v{0.3 * u(random), 0.3 * u(random), 0.3 * u(random)};
    exchanged -= kT * dot(sent, v);
    const Wrenchd out = port.control({v * (20 * (u(random) + bias)), {}}, {v, {}});
    sent = out.force * std::abs(u(random));  // a limiter behind it: what was sent counts
    port.record_sent({sent, {}});
    const Passivity::Port& p = port.state.translation;
    REQUIRE(p.in_J - p.out_J == Approx(exchanged).margin(1e-9));
    REQUIRE(p.energy_J == Approx(p.in_J - p.out_J - p.dropped_J + p.forgiven_J).margin(1e-9));
    REQUIRE(p.energy_J >= -port.config.translation.debt_cap_J);
    REQUIRE(p.energy_J <= port.config.translation.energy_cap_J);
    REQUIRE(p.alpha <= port.config.translation.max_damping);
    REQUIRE((p.alpha > 0) == ((port.status() & kPassivityActive) != 0));
  }
  CHECK(port.state.translation.forgiven_J > 0);
  CHECK(port.state.translation.dropped_J > 0);
}

TEST_CASE("the damping that is due pays the debt of the last tick, against the motion") {
  Passivity port = make_port();
  port.record_sent({{1, 0, 0}, {}});
  // 1 N along 0.4 m/s over 1 ms: 0.4 mJ out of the virtual side; alpha = 0.4e-3 / (1e-3 0.16) = 2.5.
  const Wrenchd out = port.control({{0, 7, 0}, {0, 0, 1}}, {{0.4, 0, 0}, {}});
  CHECK(port.state.translation.energy_J == Approx(-0.4e-3));
  CHECK(port.state.translation.alpha == Approx(2.5));
  CHECK(out.force.x == Approx(-1.0));
  CHECK(out.force.y == 7);
  CHECK(out.torque == Vec3d{0, 0, 1});
  port.record_sent({{-1, 0, 0}, {}});
  port.control({}, {{0.4, 0, 0}, {}});
  CHECK(port.state.translation.energy_J == Approx(0).margin(1e-15));
  CHECK(port.state.translation.dissipated_J == Approx(0.4e-3));
}

TEST_CASE("rotation has an energy balance of its own: a spring's energy does not pay for a torque") {
  Passivity port = make_port();
  port.record_sent({{-1, 0, 0}, {0, 0, 0.01}});
  const Wrenchd out = port.control({}, {{0.4, 0, 0}, {0, 0, 2}});
  CHECK(port.state.translation.energy_J > 0);
  CHECK(out.force == Vec3d{});
  CHECK(port.state.rotation.energy_J == Approx(-0.02e-3));
  CHECK(out.torque.z == Approx(-0.01));  // alpha = 0.02e-3 / (1e-3 4) = 0.005
  CHECK(port.state.rotation.alpha == Approx(0.005));
}

TEST_CASE("below the speed that the device resolves, nothing is damped, and the energy debt is kept") {
  Passivity port = make_port();
  port.state.translation.energy_J = -1e-3;
  const Wrenchd wanted{{1, 2, 3}, {}};
  CHECK(same_bits(port.control(wanted, {{0.99e-3, 0, 0}, {}}), wanted));
  CHECK(port.state.translation.energy_J == -1e-3);
  CHECK_FALSE(same_bits(port.control(wanted, {{1.01e-3, 0, 0}, {}}), wanted));
}

TEST_CASE("what is not finite is not counted and not damped: the limiter judges it") {
  Passivity port = make_port();
  port.state.translation.energy_J = -1e-3;
  port.record_sent({{1, 0, 0}, {}});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(std::isnan(port.control({{nan, 0, 0}, {}}, {{1, 0, 0}, {}}).force.x));
  CHECK(port.control({{3, 0, 0}, {}}, {{nan, 0, 0}, {}}).force.x == 3);
  CHECK(port.state.translation.energy_J == -1e-3);
  CHECK(port.status() == 0);
}

TEST_CASE("a wrench counts with the motion under which the device holds it, the delay after it was sent") {
  const double delay_ticks = GENERATE(0.0, 1.0, 2.0, 32.0);
  const int late = static_cast<int>(delay_ticks);
  Passivity port = make_port(delay_ticks);
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> u(-1, 1);
  std::vector<Vec3d> sent, motion;
  double exchanged_J = 0;
  for (int k = 0; k < 500; ++k) {
    const Vec3d v{u(random), u(random), u(random)};
    port.control({}, {v, {}});
    const int held = k - 1 - late;
    if (held >= 0) exchanged_J -= kT * dot(sent[static_cast<std::size_t>(held)], v);
    REQUIRE(port.state.translation.in_J - port.state.translation.out_J == Approx(exchanged_J).margin(1e-12));
    sent.push_back({u(random), u(random), u(random)});
    port.record_sent({sent.back(), {}});
  }
  CHECK(std::abs(exchanged_J) > 1e-3);
}

TEST_CASE("of a delay between two ticks both wrenches count, each for its part of the tick") {
  Passivity port = make_port(0.25);
  port.record_sent({{8, 0, 0}, {}});
  port.record_sent({{4, 0, 0}, {}});
  port.control({}, {{1, 0, 0}, {}});
  CHECK(port.state.translation.out_J == Approx(kT * (0.75 * 4 + 0.25 * 8)));
}

TEST_CASE("damping that is already on its way is not requested again") {
  Passivity port = make_port(2);
  const Twistd v{{0.4, 0, 0}, {}};
  port.record_sent({{1, 0, 0}, {}});
  for (int k = 0; k < 2; ++k) {
    CHECK(port.control({}, v).force.x == 0);
    port.record_sent({});
  }
  double asked_J = 0;
  for (int k = 0; k < 8; ++k) {
    const Wrenchd out = port.control({}, v);
    asked_J -= kT * dot(out.force, v.linear);
    port.record_sent(out);
  }
  CHECK(asked_J == Approx(0.4e-3));  // what 1 N gave along 0.4 mm, once
  CHECK(port.state.translation.energy_J == Approx(0).margin(1e-15));
}

TEST_CASE(
    "a late spring with damping that is passive by its own balance alone is held, at 2 and 2.5 of what is accepted") {
  const int late = GENERATE(0, 1, 2);
  const double share = GENERATE(2.0, 2.5);
  DeviceProperties device;
  device.delay_s = late * kT;
  CouplingGains gains;
  const double accepted = check_coupling(gains, device, kT).translation.stiffness_allowed;
  gains.stiffness_N_per_m = share * accepted;
  struct Run {
    double given_J{0};
    int active_ticks{0};
  };
  const auto run = [&](bool controlled) {
    Run result;
    Passivity port{Passivity::Config::of(device, gains, kT), {}};
    Hand hand;
    hand.v = {0.1, 0, 0};
    std::vector<Vec3d> sent(static_cast<std::size_t>(late) + 1);
    for (int k = 0; k < 5000; ++k) {
      Wrenchd wanted{hand.x * -gains.stiffness_N_per_m - hand.mean_velocity * gains.damping_Ns_per_m, {}};
      const double stored_J = 0.5 * gains.stiffness_N_per_m * norm_squared(hand.x);
      if (controlled) wanted = port.control(wanted, {hand.mean_velocity, {}}, {stored_J, 0});
      port.record_sent(wanted);
      sent.insert(sent.begin(), wanted.force);
      sent.pop_back();
      hand.move(sent.back() - hand.v * device.damping_Ns_per_m);
      result.given_J = std::max(result.given_J, hand.kinetic_J());
      if (port.status() != 0) ++result.active_ticks;
    }
    return result;
  };
  const double start_J = 0.5 * kMass * 0.1 * 0.1;
  CHECK(run(false).given_J > 1);
  const Run with = run(true);
  CHECK(with.active_ticks > 0);
  CHECK(with.given_J < start_J + 0.05);
}
