#include "firmware/controller.h"

#include <catch2/catch.hpp>
#include <random>

#include "tests/firmware/controller_bench.h"

using namespace tactus::firmware;

TEST_CASE("three missed commands fade the effort and exactly ten brake") {
  for (unsigned missed = 0; missed <= 12; ++missed) {
    CAPTURE(missed);
    Bench b = bench_in(State::kForce);
    b.command(State::kForce, {8, 0, 0, 0, 0, 0});
    b.nothing(static_cast<int>(missed));
    const float share = missed < 3 ? 1.0f : missed >= 10 ? 0.0f : static_cast<float>(10 - missed) / 8.0f;
    CHECK(b.outputs.effort[0] == Approx(8.0f * share));
    CHECK((b.state() == State::kBrake) == (missed >= 10));
    CHECK(((b.frame.limits & bit_of(Limit::kFading)) != 0) == (missed >= 3 && missed < 10));
    CHECK(b.frame.missed_commands == missed);
    CHECK(b.controller.fault() == (missed >= 10 ? Fault::kCommandsLost : Fault::kNone));
  }
}

TEST_CASE("a command before the tenth miss ends the fade at once") {
  Bench b = bench_in(State::kForce);
  b.nothing(9);
  CHECK(b.state() == State::kForce);
  b.command(State::kForce, {8, 0, 0, 0, 0, 0});
  CHECK(b.outputs.effort[0] == 8.0f);
  CHECK(b.frame.missed_commands == 0);
}

TEST_CASE("the thresholds are the configuration's") {
  Config c = configuration();
  c.fade_frames = 1;
  c.brake_frames = 4;
  Bench b(c);
  b.command(State::kIdle);
  b.command(State::kIdle);
  b.command(State::kForce, {8, 0, 0, 0, 0, 0});
  b.nothing();
  CHECK(b.outputs.effort[0] == Approx(8.0f * 3.0f / 4.0f));
  b.nothing(2);
  CHECK(b.state() == State::kForce);
  b.nothing();
  CHECK(b.state() == State::kBrake);
}

TEST_CASE("a device without commands is idle and has no fault") {
  Bench b;
  b.nothing(1000);
  CHECK(b.state() == State::kIdle);
  CHECK(b.controller.fault() == Fault::kNone);
  CHECK(b.frame.missed_commands == 255);
}

TEST_CASE("only frames that are new, whole and finite feed the watchdog") {
  const auto missed_after = [](auto&& deliver) {
    Bench b = bench_in(State::kForce);
    deliver(b);
    return b.frame.missed_commands;
  };
  CHECK(missed_after([](Bench& b) { b.command(State::kForce); }) == 0);
  CHECK(missed_after([](Bench& b) {  // frames were lost
          b.sequence += 1000;
          b.command(State::kForce);
        }) == 0);
  CHECK(missed_after([](Bench& b) { b.send({State::kForce, false, b.sequence, {}}); }) == 1);      // duplicate
  CHECK(missed_after([](Bench& b) { b.send({State::kForce, false, b.sequence - 1, {}}); }) == 1);  // late
  CHECK(missed_after([](Bench& b) { b.send({State::kForce, false, b.sequence - 1000, {}}); }) == 1);
  CHECK(missed_after([](Bench& b) { b.command(State::kForce, {0, 0, 0, 0, 0, kInfinity}); }) == 1);
  CHECK(missed_after([](Bench& b) {
          std::array<std::byte, kCommandFrameSize> bytes{};
          encode_command({State::kForce, false, ++b.sequence, {}}, bytes);
          bytes[13] ^= std::byte{4};
          b.step(bytes);
        }) == 1);
  CHECK(missed_after([](Bench& b) {
          const auto own = b.outputs.state_frame;  // the wrong direction's frame
          b.step(own);
        }) == 1);
}

TEST_CASE("an old frame that comes late moves no motor") {
  Bench b = bench_in(State::kForce);
  b.command(State::kForce, {1, 0, 0, 0, 0, 0});
  b.send({State::kForce, false, b.sequence - 1, {9, 0, 0, 0, 0, 0}});
  CHECK(b.outputs.effort[0] == 1.0f);
  CHECK(b.controller.refused_frames() == 1);
}

TEST_CASE("sequences may wrap while force is on") {
  Bench b;
  b.sequence = 0xfffffffau;
  b.command(State::kIdle);
  for (int i = 0; i < 12; ++i) {
    b.command(State::kForce, {1, 0, 0, 0, 0, 0});
    REQUIRE(b.state() == State::kForce);
    REQUIRE(b.frame.echoed_sequence == b.sequence);
  }
  CHECK(b.sequence < 100);
}

TEST_CASE("a host that starts afresh is understood after ten silent periods, not before") {
  Bench b = bench_in(State::kIdle);
  b.sequence = 5000;
  b.command(State::kIdle);
  b.sequence = 0;  // the host's program was started again
  b.command(State::kForce);
  CHECK(b.state() == State::kIdle);
  b.nothing(9);
  b.command(State::kForce);  // starts the sequence, and nothing else
  CHECK(b.state() == State::kIdle);
  CHECK(b.frame.echoed_sequence == b.sequence);
  b.command(State::kForce);
  CHECK(b.state() == State::kForce);
}

TEST_CASE("a frame left over from before a silence starts no force, however often it comes") {
  Bench b = bench_in(State::kIdle);
  b.nothing(50);
  const CommandFrame old{State::kForce, false, 3, {9, 0, 0, 0, 0, 0}};
  for (int i = 0; i < 5; ++i) {
    b.send(old);
    CHECK(b.state() == State::kIdle);
    CHECK(b.norm_of_effort() == 0.0f);
  }
}

TEST_CASE("BRAKE latches until the re-arm flag rises, and force needs a command of its own") {
  Bench b = bench_in(State::kForce);
  b.nothing(10);
  REQUIRE(b.state() == State::kBrake);
  for (int i = 0; i < 100; ++i) b.command(State::kForce, {5, 0, 0, 0, 0, 0});
  CHECK(b.state() == State::kBrake);
  CHECK(b.controller.fault() == Fault::kCommandsLost);
  b.command(State::kForce, {5, 0, 0, 0, 0, 0}, true);
  CHECK(b.state() == State::kIdle);
  CHECK(b.controller.fault() == Fault::kNone);
  CHECK(b.norm_of_effort() == 0.0f);
  b.command(State::kForce, {5, 0, 0, 0, 0, 0});
  CHECK(b.state() == State::kForce);
  CHECK(b.outputs.effort[0] == 5.0f);
}

TEST_CASE("a re-arm flag that is stuck does not defeat the latch") {
  Bench b = bench_in(State::kForce);
  for (int i = 0; i < 5; ++i) b.command(State::kForce, {}, true);
  b.command(State::kBrake, {}, true);
  for (int i = 0; i < 20; ++i) b.command(State::kForce, {}, true);
  CHECK(b.state() == State::kBrake);
  b.nothing(20);  // nor over a silence
  for (int i = 0; i < 20; ++i) b.command(State::kForce, {}, true);
  CHECK(b.state() == State::kBrake);
  b.command(State::kForce, {}, false);
  b.command(State::kForce, {}, true);
  CHECK(b.state() == State::kIdle);
}

TEST_CASE("the e-stop zeroes the effort in its own period, latches, and re-arms only once released") {
  Bench b = bench_in(State::kForce);
  REQUIRE(b.norm_of_effort() > 0.0f);
  b.inputs.emergency_stop = true;
  b.command(State::kForce, {5, 0, 0, 0, 0, 0});
  CHECK(b.norm_of_effort() == 0.0f);
  CHECK(b.outputs.brake);
  CHECK((b.frame.limits & bit_of(Limit::kEmergencyStop)) != 0);
  b.command(State::kForce, {}, true);
  CHECK(b.state() == State::kBrake);
  b.inputs.emergency_stop = false;
  b.command(State::kForce, {}, false);
  CHECK(b.state() == State::kBrake);
  CHECK(b.controller.fault() == Fault::kEmergencyStop);
  CHECK((b.frame.limits & bit_of(Limit::kEmergencyStop)) == 0);
  b.command(State::kForce, {}, true);
  CHECK(b.state() == State::kIdle);
}

TEST_CASE("the first cause of a BRAKE is the one that is reported") {
  Bench b = bench_in(State::kForce);
  b.command(State::kForce, {kNan});
  b.inputs.motor_bus_ok = false;
  b.command(State::kForce);
  CHECK(b.controller.fault() == Fault::kEffortNotFinite);
  CHECK((b.frame.limits & bit_of(Limit::kMotorBusLow)) != 0);
}

TEST_CASE("efforts that are no numbers never reach the motors") {
  for (const float bad : {kNan, kInfinity, -kInfinity})
    for (unsigned axis = 0; axis < kAxes; ++axis) {
      Bench b = bench_in(State::kForce);
      std::array<float, kAxes> effort{1, 1, 1, 0.1f, 0.1f, 0.1f};
      effort[axis] = bad;
      b.command(State::kForce, effort);
      CHECK(b.state() == State::kBrake);
      CHECK(b.controller.fault() == Fault::kEffortNotFinite);
      CHECK(b.norm_of_effort() == 0.0f);
    }
}

TEST_CASE("no effort exceeds its motor or its norm, the direction is kept, and each limit shows") {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<float> force(-20.0f, 20.0f), torque(-2.0f, 2.0f), exponent(-3.0f, 37.0f);
  Bench b = bench_in(State::kForce);
  for (int i = 0; i < 50000; ++i) {
    std::array<float, kAxes> wanted{force(random),  force(random),  force(random),
                                    torque(random), torque(random), torque(random)};
    if (i % 5 == 0)
      for (float& w : wanted) w *= std::pow(10.0f, exponent(random));
    b.command(State::kForce, wanted);
    for (unsigned group = 0; group < 2; ++group) {
      const float motor = group == 0 ? kMotor : kMotorTorque, max_norm = group == 0 ? kForceNorm : kTorqueNorm;
      const float* w = &wanted[3 * group];
      const float* e = &b.outputs.effort[3 * group];
      double scale = 1.0, norm = 0.0;
      for (int k = 0; k < 3; ++k) {
        const double ratio = static_cast<double>(motor) / std::abs(static_cast<double>(w[k]));
        scale = std::min(scale, ratio);
        const bool bit = (b.frame.limits & axis_limit_bit(3 * group + static_cast<unsigned>(k))) != 0;
        REQUIRE(bit == (std::abs(w[k]) > motor));
      }
      for (int k = 0; k < 3; ++k) norm += std::pow(scale * static_cast<double>(w[k]), 2);
      norm = std::sqrt(norm);
      const double limit = static_cast<double>(max_norm);
      if (std::abs(norm - limit) > 1e-4 * limit)
        REQUIRE(((b.frame.limits & bit_of(group == 0 ? Limit::kForce : Limit::kTorque)) != 0) == (norm > limit));
      scale *= std::min(1.0, limit / norm);
      double sent_norm = 0.0;
      for (int k = 0; k < 3; ++k) {
        REQUIRE(std::abs(e[k]) <= motor);
        REQUIRE(static_cast<double>(e[k]) == Approx(scale * static_cast<double>(w[k])).margin(1e-5));
        sent_norm += std::pow(static_cast<double>(e[k]), 2);
      }
      REQUIRE(std::sqrt(sent_norm) <= limit * (1.0 + 1e-6));
    }
  }
}

TEST_CASE("a norm too small to be squared holds all the same") {
  Config config = configuration();
  config.max_force_N = 1e-39f;
  Bench b(config);
  b.command(State::kIdle);
  for (const float effort : {1e-26f, 1e-14f, 1.0f}) {
    b.command(State::kForce, {effort, -effort, 0, 0, 0, 0});
    CHECK(std::hypot(static_cast<double>(b.outputs.effort[0]), static_cast<double>(b.outputs.effort[1])) <= 1e-30);
  }
}

TEST_CASE("an axis without a motor gets no effort") {
  Config c = configuration();
  c.max_effort[3] = c.max_effort[4] = c.max_effort[5] = 0.0f;
  Bench b(c);
  b.command(State::kIdle);
  b.command(State::kForce);
  b.command(State::kForce, {1, 0, 0, 0.5f, 0.5f, -0.5f});
  CHECK(b.outputs.effort == std::array<float, kAxes>{1, 0, 0, 0, 0, 0});
}

TEST_CASE("overspeed brakes above the limit of the axis, not at it") {
  for (unsigned axis = 0; axis < kAxes; ++axis)
    for (const int direction : {-1, 1}) {
      Bench b = bench_in(State::kForce);
      const std::int32_t at_limit = 199;  // of 200 quanta per period: 2 m/s, 20 rad/s
      b.inputs.counts[axis] += direction * at_limit;
      b.command(State::kForce);
      CHECK(b.state() == State::kForce);
      b.inputs.counts[axis] += direction * 201;
      b.command(State::kForce);
      CHECK(b.state() == State::kBrake);
      CHECK(b.controller.fault() == Fault::kOverspeed);
    }
}

TEST_CASE("the state frame contains sequence, time, counts and buttons of its own period") {
  Bench b;
  for (std::uint32_t i = 1; i < 100; ++i) {
    b.inputs.counts = {static_cast<std::int32_t>(i), 2, 3, 4, 5, -6};
    b.inputs.buttons = static_cast<std::uint8_t>(i);
    b.nothing();
    REQUIRE(b.frame.sequence == i);
    REQUIRE(b.frame.time_us == 1000u * i);
    REQUIRE(b.frame.counts == b.inputs.counts);
    REQUIRE(b.frame.buttons == static_cast<std::uint8_t>(i));
  }
}

TEST_CASE("a configuration that makes no sense is refused") {
  const auto refuses = [](auto&& spoil) {
    Config c = configuration();
    spoil(c);
    Bench b(c);
    for (int i = 0; i < 5; ++i) b.command(State::kForce, {1, 0, 0, 0, 0, 0}, i % 2 == 1);
    return !is_valid(c) && b.state() == State::kReset && b.controller.fault() == Fault::kBadConfiguration &&
           b.norm_of_effort() == 0.0f && b.outputs.brake;
  };
  CHECK(is_valid(configuration()));
  CHECK(refuses([](Config& c) { c.quantum[2] = 0.0f; }));
  CHECK(refuses([](Config& c) { c.max_effort[0] = kNan; }));
  CHECK(refuses([](Config& c) { c.max_effort[0] = -1.0f; }));
  CHECK(refuses([](Config& c) { c.max_speed[5] = 0.0f; }));
  CHECK(refuses([](Config& c) { c.max_force_N = kInfinity; }));
  CHECK(refuses([](Config& c) { c.max_torque_Nm = 1e30f; }));
  CHECK(refuses([](Config& c) { c.period_us = 0; }));
  CHECK(refuses([](Config& c) { c.fade_frames = 0; }));
  CHECK(refuses([](Config& c) { c.fade_frames = c.brake_frames; }));
}

TEST_CASE("random bytes never move a motor beyond its limit") {
  std::mt19937_64 random(5);
  Bench b = bench_in(State::kForce);
  for (int i = 0; i < 50000; ++i) {
    std::array<std::byte, kMaxFrameSize> bytes{};
    for (auto& x : bytes) x = static_cast<std::byte>(random());
    b.step(std::span<const std::byte>(bytes).first(random() % (kMaxFrameSize + 1)));
    for (const float e : b.outputs.effort) REQUIRE(std::abs(e) <= kMotor);
  }
  CHECK(b.state() == State::kBrake);
}
