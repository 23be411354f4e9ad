// A force-feedback device without hardware: the real firmware, arm mechanics, a hand that holds the tool,
// and a link with delay and injected faults. Replaces a real device anywhere (concept HapticDevice).
//
// One read() is one control period of the device, in this order:
//   the mechanics advance one period under the present efforts -> encoders -> Device::step with the command that has
//   arrived -> the state frame enters the link -> the frame that arrives now is decoded.
// write() encodes a command and puts it onto the link; the firmware sees it in the next period at the earliest, so
// the smallest transport delay is one tick. Device time advances with read() only, independent of real time.
// Thread: construction [setup]; read(), write() [rt] by the loop's thread: no allocation, no lock, bounded (sub-steps
// of the mechanics are fixed). The accessors return the exact simulated state, for tests and summaries; same thread.
// Frame: the device's. Units: SI. Deterministic: the same arguments and commands give the same bits.
#pragma once

#include <optional>

#include "firmware/device.h"
#include "hal/fault_injection.h"
#include "hal/frame_codec.h"
#include "hal/operated_hand.h"
#include "hal/plant.h"
#include "hal/simulated_link.h"
#include "hal/told_idle.h"

namespace tactus::hal {

struct SimulationOptions {
  std::int64_t period_ns{1'000'000};              // from one read() to the next, 50 us to 1 s
  unsigned sub_steps{4};                          // of the mechanics per period, 1 to 64
  std::optional<unsigned> transport_delay_ticks;  // 1 to 32; default: the profile's
  std::uint64_t seed{1};                          // of the random faults
  FaultScript faults;
};

class SimulatedDevice {
 public:
  // [setup] The tool starts at rest in the hand, at the first pose of the hand's path. The firmware has already
  // received an IDLE command, so that the first command may enter FORCE. Call check(options) first.
  SimulatedDevice(const DeviceProfile& profile, HandModel hand, const SimulationOptions& options);

  // [setup] One line: which option is out of its range.
  static Status check(const SimulationOptions& options);

  const haptics::DeviceProperties& properties() const noexcept { return properties_; }
  void read(haptics::DeviceInput& input) noexcept;
  void write(const haptics::DeviceCommand& command) noexcept;

  // A new trial [rt]. return_hand(): the hand returns to the start of its path and rests there. hand_is_back(): it has
  // arrived and the vibration has decayed. start_path(): it follows the path again, from `into_s` after its beginning.
  void return_hand() noexcept;
  bool hand_is_back() const noexcept;
  void start_path(double into_s) noexcept;

  // A person operates the hand [rt], see OperatedHand. take_hand(): from where it is now, until return_hand().
  // lead_hand(): to this far from there, in the device's frame [m; rotation vector, rad]. hold_hand(): it rests where
  // it is.
  void take_hand() noexcept;
  void lead_hand(const Vec3d& moved, const Vec3d& turned) noexcept;
  void hold_hand() noexcept;
  bool hand_is_operated() const noexcept { return hand_is_operated_; }

  // --- the exact simulated state
  std::uint64_t tick() const noexcept { return now_; }  // of the last read, from 0
  std::int64_t period_ns() const noexcept { return options_.period_ns; }
  const Plant& plant() const noexcept { return plant_; }
  const HandModel& hand() const noexcept { return hand_; }
  HandTarget hand_target() const noexcept { return target_at(now_, 0); }
  const firmware::Controller& controller() const noexcept { return device_.controller(); }
  const firmware::ControllerOutputs& motor_outputs() const noexcept { return outputs_; }  // applied until the next read

  void set_buttons(std::uint8_t buttons) noexcept { buttons_ = buttons; }  // bit 0 first

 private:
  using StateBytes = std::array<std::byte, firmware::kStateFrameSize>;

  double time_s(std::uint64_t tick, unsigned sub_step) const noexcept;
  HandTarget target_at(std::uint64_t tick, unsigned sub_step) const noexcept;
  const InjectedFault* fault(FaultKind kind, FaultDirection direction) const noexcept;
  firmware::AxisCounts counts() const noexcept;  // of the encoders now
  void advance_plant() noexcept;
  void run_firmware() noexcept;
  void send_state(const StateBytes& fresh) noexcept;
  void receive_state(haptics::DeviceInput& input) noexcept;
  void distort(StateBytes& bytes) noexcept;
  void flip_bits(std::span<std::byte> bytes, unsigned count) noexcept;
  std::uint64_t random() noexcept;

  SimulationOptions options_;
  haptics::DeviceProperties properties_;
  AxisVector quantum_;
  double travel_per_axis_;  // m of the tool at the centre per unit of axis 0
  std::uint64_t state_delay_ticks_, command_delay_ticks_;
  HandModel hand_;
  std::uint64_t hand_since_{0};  // tick at which the hand's path, or its return, began
  double path_from_s_{0};        // path time at that tick
  bool hand_returns_{false};
  OperatedHand operated_hand_;
  bool hand_is_operated_{false};
  Posed return_from_;
  Plant plant_;
  firmware::Device device_;
  firmware::ControllerOutputs outputs_;
  FrameCodec codec_;
  SimulatedLink state_link_, command_link_;
  std::array<std::byte, firmware::kCommandFrameSize> waiting_command_{}, last_command_{};
  StateBytes last_state_{};
  haptics::DeviceSample sample_;  // the newest valid one
  std::uint64_t reads_{0}, now_{0}, random_state_;
  bool command_waits_{false}, command_sent_{false}, state_sent_{false};
  std::uint8_t buttons_{0};
};

static_assert(haptics::HapticDevice<SimulatedDevice>);

}  // namespace tactus::hal
