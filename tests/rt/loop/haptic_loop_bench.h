// A haptic loop with a device that obeys every command and reports the pose that the test sets. The proxy is so heavy
// that the force is known. Frame: device, which is the world's unless a test places it elsewhere. Units: SI.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <limits>

#include "rt/loop/haptic_loop.h"

namespace tactus::test::haptic_loop_bench {

using haptics::CouplingScheme;
using haptics::DeviceState;
using haptics::ReadStatus;
using loop::HapticLoop;
using loop::kArm;
using loop::LoopConfig;
using loop::TickInput;
using loop::TickOutput;
using physics::Body;
using physics::Shape;

inline constexpr BodyId kProxy = 0;
inline constexpr double kStiffness = 2000, kRotationStiffness = 5;
inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
inline constexpr std::uint32_t kEmergencyStop = 77;

inline LoopConfig make_config(CouplingScheme scheme = CouplingScheme::kDirect) {
  LoopConfig config;
  config.sub_world.scheme = scheme;
  config.sub_world.border_mode = physics::BorderMode::kCapped;
  config.sub_world.ratio = 5;
  config.sub_world.proxy = kProxy;
  config.sub_world.step.dt = config.period_s;
  config.sub_world.gains.stiffness_N_per_m = kStiffness;
  config.sub_world.gains.stiffness_Nm_per_rad = kRotationStiffness;
  config.sub_world.capacities = {.bodies = 8, .fixed_bodies = 2, .pairs = 32, .contacts = 32, .border_contacts = 4};
  config.emergency_stop_fault = kEmergencyStop;
  return config;
}

// So heavy that it stays where it is: the coupling's wrench is K times the stretch.
inline Body anvil(const Posed& pose = {}) {
  return physics::make_dynamic_body(kProxy, Shape::sphere(0.5), 1e9, 0.5, pose);
}

// A loop, and a device that obeys every command and reports the pose `tool`.
struct Bench {
  explicit Bench(const LoopConfig& config = make_config(), const Body& proxy = anvil()) : loop(config, {}) {
    in.device.sample.state = DeviceState::kIdle;
    if (!loop.sub_world().exchanges()) loop.set_members({&proxy, 1});
  }

  HapticLoop loop;
  TickInput in;
  TickOutput out;
  Posed tool;
  Vec3d last_force;
  double force_step_max{0};
  bool deaf{false};  // the device receives no command

  TickOutput& tick(std::uint32_t operator_bits = 0, ReadStatus status = ReadStatus::kFresh) {
    auto& sample = in.device.sample;
    in.device.status = status;
    if (status == ReadStatus::kFresh) {
      ++sample.sequence;
      sample.device_time_ns += 1'000'000;
      sample.device_from_tool = tool;
    }
    in.operator_bits = operator_bits;
    loop.tick(in, out);
    if (sample.state != DeviceState::kBrake || out.command.wanted == DeviceState::kBrake)
      sample.state = out.command.wanted;
    if (out.command.rearm != 0) sample.state = DeviceState::kIdle;
    if (!deaf) sample.echoed_sequence = out.command.sequence;
    force_step_max = std::max(force_step_max, norm(out.command.wrench.force - last_force));
    last_force = out.command.wrench.force;
    return out;
  }
  void run(int ticks) {
    for (int i = 0; i < ticks; ++i) tick();
  }
  // Arms the loop, moves the tool by `stretch` and waits for the end of the ramp.
  void hold(const Vec3d& stretch) {
    run(3);
    tick(kArm);
    move(stretch);
    run(300);
  }
  // Moves the tool along a line, slower than the speed at which the guard rejects samples.
  void move(const Vec3d& by) {
    const int ticks = static_cast<int>(norm(by) / 0.5e-3) + 1;
    for (int i = 0; i < ticks; ++i) {
      tool.position += (1.0 / ticks) * by;
      tick();
    }
  }
  double force() const { return norm(out.command.wrench.force); }
};

inline void check_close(const Vec3d& a, const Vec3d& b, double within) {
  CAPTURE(a.x, a.y, a.z, b.x, b.y, b.z);
  CHECK(norm(a - b) <= within);
}

}  // namespace tactus::test::haptic_loop_bench
