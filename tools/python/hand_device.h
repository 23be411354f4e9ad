// A simulated device whose owner supplies one target, or one wrench, of the hand per tick: the arm of the scene's
// profile, with its encoders and the delay of its link. With a target the impedance of the scene's [hand] moves the
// arm; with a wrench the wrench alone, with the hand's mass on the arm. No link, so no injected faults.
//
// Thread: one, in virtual time. Frame: targets, and what the owner receives, in the world; the Device's own interface
// in the device's. Bound: read() takes the owner's time plus a constant.
#pragma once

#include <deque>
#include <functional>
#include <optional>
#include <variant>

#include "hal/plant.h"
#include "sim/model/scene.h"
#include "tactus/device.h"

namespace tactus::python {

struct HandPose {
  Vector3 position_m{};
  Quaternion rotation{1, 0, 0, 0};
};

// The wrench with which a hand pushes the tool, instead of a target pose; about the tool's origin, world axes.
struct HandPush {
  Vector3 force_N{};
  Vector3 torque_Nm{};
};
using HandWish = std::variant<HandPose, HandPush>;

// The argument of the owner's function, which is called once a tick.
struct HandAsked {
  std::uint64_t tick{0};  // the target is for this tick's sample
  HandPose tool;          // as the encoders measure it
  Vector3 force_N{};      // on the hand: what the motors apply now
  Vector3 torque_Nm{};    // same, about the tool's origin
};

// Sets `wish` to the target pose at the end of the coming period, or to the wrench that the hand applies until then.
// False: the wish of the tick before continues.
using AskHand = std::function<bool(const HandAsked& asked, HandWish& wish)>;

class HandDevice final : public Device {
 public:
  // Everything that the next read depends on.
  struct State {
    hal::Plant plant;
    Posed target;                        // device frame
    std::optional<Wrenchd> push;         // same; the hand pushes, and has no target
    std::deque<DeviceCommand> commands;  // on their way to the motors, the oldest first
    hal::AxisVector effort{};            // of the motors
    bool brake{false};
    Wrenchd felt;  // device frame: what `effort` is for
    std::uint64_t reads{0};
  };

  HandDevice(const sim::Scene& scene, const hal::DeviceProfile& profile, double period_s, AskHand ask);

  DeviceProperties properties() const override;
  Error start(double period_s) override;
  Reading read(DeviceSample& sample) noexcept override;
  void write(const DeviceCommand& command) noexcept override;

  const State& state() const noexcept { return state_; }
  void set_state(const State& state) { state_ = state; }

 private:
  State initial_state() const;
  Posed measured() const noexcept;  // device frame
  void advance() noexcept;
  void apply_next_command() noexcept;
  HandPose to_world(const Posed& device_from_tool) const noexcept;
  Posed to_device(const HandPose& pose) const noexcept;
  void step_plant(const Posed& from) noexcept;

  sim::SceneDevice placement_;
  hal::DeviceProfile profile_;
  hal::HandModel hand_;
  double period_s_;
  AskHand ask_;
  State state_;
};

}  // namespace tactus::python
