// A controller on a bench, for its tests: one call, one control period.
#pragma once

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <optional>

#include "firmware/controller.h"

namespace tactus::firmware {

inline constexpr float kMotor = 10.0f, kForceNorm = 12.0f, kMotorTorque = 1.0f, kTorqueNorm = 1.2f;
inline const float kNan = std::numeric_limits<float>::quiet_NaN(), kInfinity = std::numeric_limits<float>::infinity();

inline Config configuration() {
  Config c;
  c.quantum = {1e-5f, 1e-5f, 1e-5f, 1e-4f, 1e-4f, 1e-4f};
  c.max_effort = {kMotor, kMotor, kMotor, kMotorTorque, kMotorTorque, kMotorTorque};
  c.max_speed = {2, 2, 2, 20, 20, 20};
  c.max_force_N = kForceNorm;
  c.max_torque_Nm = kTorqueNorm;
  return c;
}

// A controller on a bench: one call, one control period.
struct Bench {
  Controller controller;
  ControllerInputs inputs;
  Supervision supervision;
  StateFrame frame;  // the last one sent
  ControllerOutputs outputs;
  std::uint32_t sequence{0};

  explicit Bench(const Config& config = configuration()) : controller(config) {}

  void step(std::span<const std::byte> bytes) {
    inputs.time_us += 1000;
    outputs = controller.step(inputs, bytes, supervision);
    REQUIRE(decode_state(outputs.state_frame, frame) == DecodeError::kNone);
  }
  void nothing(int periods = 1) {
    for (int i = 0; i < periods; ++i) step({});
  }
  void send(const CommandFrame& command) {
    std::array<std::byte, kCommandFrameSize> bytes{};
    encode_command(command, bytes);
    step(bytes);
  }
  void command(State wanted, std::array<float, kAxes> effort = {}, bool rearm = false) {
    send({wanted, rearm, ++sequence, effort});
  }
  State state() const { return controller.state(); }
  float norm_of_effort() const {
    float sum = 0;
    for (const float e : outputs.effort) sum += e * e;
    return std::sqrt(sum);
  }
};

// A bench in the wanted state, with the host heard of (its next command is obeyed).
inline Bench bench_in(State state) {
  Bench b;
  if (state == State::kReset) {
    b.inputs.motor_bus_ok = false;
    b.command(State::kIdle);
    b.inputs.motor_bus_ok = true;
    return b;
  }
  b.command(State::kIdle);
  b.command(State::kIdle);
  if (state == State::kForce) b.command(State::kForce, {1, 2, 3, 0.1f, 0.2f, 0.3f});
  if (state == State::kBrake) b.command(State::kBrake);
  return b;
}

}  // namespace tactus::firmware
