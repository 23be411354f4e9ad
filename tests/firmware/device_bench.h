// A whole device on a bench: one call, one control period; and the questions that a host asks it.
#pragma once

#include <bit>
#include <catch2/catch.hpp>
#include <concepts>

#include "tests/support/bench_config.h"

namespace tactus::firmware {

struct DeviceBench {
  Device device;
  ControllerInputs inputs;
  StateFrame frame;  // the last one sent
  ControllerOutputs outputs;
  std::uint32_t sequence{0};

  explicit DeviceBench(const DeviceConfig& config = bench_config(), const Identity& identity = {})
      : device(config, identity) {}

  void step(std::span<const std::byte> bytes) {
    inputs.time_us += 1000;
    outputs = device.step(inputs, bytes);
    inputs.index_edges = 0;  // an edge is one period's
    REQUIRE(decode_state(outputs.state_frame, frame) == DecodeError::kNone);
  }
  void nothing(int periods = 1) {
    for (int i = 0; i < periods; ++i) step({});
  }
  void command(State wanted, const AxisValues& effort = {}, bool rearm = false) {
    std::array<std::byte, kCommandFrameSize> bytes{};
    encode_command({wanted, rearm, ++sequence, effort}, bytes);
    step(bytes);
  }
  void start_force(const AxisValues& effort = {}) {
    command(State::kIdle);
    command(State::kIdle);
    command(State::kForce, effort);
  }
  void rearm() {
    command(State::kIdle);
    command(State::kIdle, {}, true);
  }

  State state() const { return device.controller().state(); }
  Fault fault() const { return device.controller().fault(); }
  bool limited(Limit limit) const { return (frame.limits & bit_of(limit)) != 0; }

  ServiceMessage ask(Operation operation, unsigned number, std::uint32_t value = 0) {
    return device.serve({operation, ServiceStatus::kGood, 7, static_cast<std::uint16_t>(number), value});
  }
  // Of any whole type: 32 bits are an int on one machine, a long on another.
  template <std::integral T>
  ServiceStatus write(unsigned number, T value) {
    return ask(Operation::kWrite, number, static_cast<std::uint32_t>(value)).status;
  }
  ServiceStatus write(unsigned number, float value) { return write(number, std::bit_cast<std::uint32_t>(value)); }
  ServiceStatus execute(unsigned number, std::uint32_t argument = 0) {
    return ask(Operation::kExecute, number, argument).status;
  }
  std::uint32_t read(unsigned number) {
    const ServiceMessage reply = ask(Operation::kRead, number);
    REQUIRE(reply.status == ServiceStatus::kGood);
    return reply.value;
  }
  float read_real(unsigned number) { return std::bit_cast<float>(read(number)); }
};

}  // namespace tactus::firmware
