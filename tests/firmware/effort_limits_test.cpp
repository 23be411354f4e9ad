// The limits of force, torque and effort, at any size, whatever is added up beneath them.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <span>

#include "firmware/controller.h"

using namespace tactus::firmware;

TEST_CASE("limits of any size hold, with the arm's weight, warm motors and a fading command") {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<float> size(-40.0f, 6.0f), unit(-1.0f, 1.0f);
  const auto any_size = [&] { return unit(random) * std::pow(10.0f, size(random)); };
  for (int i = 0; i < 20000; ++i) {
    Config config;
    config.quantum.fill(1e-5f);
    config.max_speed.fill(2.0f);
    config.max_force_N = std::abs(any_size());
    config.max_torque_Nm = std::abs(any_size());
    for (float& effort : config.max_effort) effort = std::abs(any_size());
    Controller controller(config);
    ControllerInputs inputs;
    Supervision supervision;
    for (float& support : supervision.support) support = any_size();
    for (float& share : supervision.effort_share) share = i % 3 == 0 ? std::abs(unit(random)) : 1.0f;
    const auto outputs_after = [&](const CommandFrame* command) {
      std::array<std::byte, kCommandFrameSize> bytes{};
      if (command != nullptr) encode_command(*command, bytes);
      inputs.time_us += 1000;
      return controller.step(inputs, command == nullptr ? std::span<const std::byte>{} : bytes, supervision);
    };
    CommandFrame command{State::kIdle, false, 1, {}};
    outputs_after(&command);  // starts the sequence
    command = {State::kForce, false, 2, {}};
    for (float& effort : command.effort) effort = any_size();
    for (int missed = -1; missed < 6; ++missed) {
      const ControllerOutputs outputs = outputs_after(missed < 0 ? &command : nullptr);
      REQUIRE(controller.state() == State::kForce);
      for (unsigned first = 0; first < kAxes; first += 3) {
        double norm_squared = 0.0;
        for (unsigned k = first; k < first + 3; ++k) {
          REQUIRE(std::abs(outputs.effort[k]) <= config.max_effort[k]);
          norm_squared += std::pow(static_cast<double>(outputs.effort[k]), 2);
        }
        const auto limit = static_cast<double>(first == 0 ? config.max_force_N : config.max_torque_Nm);
        REQUIRE(std::sqrt(norm_squared) <= limit * (1.0 + 1e-5) + 1e-30);
      }
    }
  }
}
