// A device that the library does not know, in the program's own process: here a weight of 0.3 kg in a gripper of
// 400 N/m, simulated, that goes down onto what is there and comes up again. Put the calls of a maker's library where
// the gripper's are.
//   own_device SCENE
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "tactus/tactus.h"

namespace {

class Gripper final : public tactus::Device {
 public:
  // As measured: all that the program promises about stability rests on these figures.
  tactus::DeviceProperties properties() const override {
    tactus::DeviceProperties p;
    p.has_rotation = false;
    p.workspace_radius_m = 0.1;
    p.max_speed_m_per_s = 1.0;
    p.max_force_N = 10.0;
    p.continuous_force_N = 5.0;
    p.max_torque_Nm = p.continuous_torque_Nm = 0.0;
    p.mass_kg = kMass_kg;
    p.damping_Ns_per_m = kDamping_Ns_per_m;
    return p;
  }

  tactus::Error start(double period_s) override {
    period_s_ = period_s;
    time_s_ = position_m_ = velocity_m_per_s_ = force_N_ = 0;
    return {};  // or what is wrong: {tactus::Error::Kind::kMachine, "no power: switch the device on"}
  }

  // One period goes by: the gripper's spring and the loop's force move the weight.
  tactus::Reading read(tactus::DeviceSample& sample) noexcept override {
    const double target_m = -0.5 * kDepth_m * (1 - std::cos(kTwoPi * time_s_ / kCycle_s));
    const double grip_N = kGrip_N_per_m * (target_m - position_m_) - kDamping_Ns_per_m * velocity_m_per_s_;
    velocity_m_per_s_ += period_s_ / kMass_kg * (grip_N + force_N_);
    position_m_ += period_s_ * velocity_m_per_s_;
    time_s_ += period_s_;
    sample.position_m = {0, 0, position_m_};
    return tactus::Reading::kFresh;
  }

  void write(const tactus::DeviceCommand& command) noexcept override {
    force_N_ = command.force_N[2];  // 0 where there is to be none
  }

 private:
  static constexpr double kTwoPi = 6.283185307179586;
  static constexpr double kMass_kg = 0.3, kDamping_Ns_per_m = 12, kGrip_N_per_m = 400;
  static constexpr double kDepth_m = 0.03, kCycle_s = 2;
  double period_s_{1e-3}, time_s_{0}, position_m_{0}, velocity_m_per_s_{0}, force_N_{0};
};

int fail(const tactus::Error& error) {
  std::fprintf(stderr, "own_device: %s\n", error.message().c_str());
  return 1;
}

}  // namespace

int main(int count, char** words) {
  if (count != 2) {
    std::fprintf(stderr, "usage: own_device SCENE\n");
    return 2;
  }
  tactus::Scene scene;
  if (const tactus::Error error = scene.load(words[1])) return fail(error);
  Gripper gripper;  // outlives the session
  tactus::Session session;
  if (const tactus::Error error = session.open(scene, {}, gripper)) return fail(error);

  double deepest_m = 0, most_N = 0;
  while (session.time_s() < 4) {
    if (const tactus::Error error = session.step(100)) return fail(error);
    for (const tactus::Tick& tick : session.ticks()) {
      deepest_m = std::min(deepest_m, tick.tool_position_m[2]);
      most_N = std::max(most_N, tick.force_N[2]);
    }
    if (session.last().fault != tactus::FaultCode::kNone) {
      std::fprintf(stderr, "own_device: %s\n", std::string(tactus::describe(session.last().fault)).c_str());
      return 1;
    }
  }
  std::printf("down to %.1f mm, pushed up by %.2f N at most, %.1f %% of the time in contact\n", 1e3 * deepest_m, most_N,
              100.0 * static_cast<double>(session.summary().contact_ticks) / static_cast<double>(session.ticks_done()));
  std::printf("state %016llx\n", static_cast<unsigned long long>(session.state_hash()));
  return most_N > 0 ? 0 : 1;
}
