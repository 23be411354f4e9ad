// A force-feedback device without hardware: the real firmware, arm mechanics, a hand that holds the tool,
// and a link with delay and injected faults. Stands wherever a real device stands (concept HapticDevice).
//
// One read() is one control period of the device, and the order in it is:
//   mechanics move on by one period under the efforts in force -> encoders -> Device::step with the command that has
//   arrived -> state frame onto the link -> the frame that arrives now is decoded.
// write() encodes a command and puts it onto the link; the firmware sees it in the next period at the earliest, so
// the smallest transport delay is one tick. Device time advances with read() alone: it does not know real time.
// Thread: construction [setup]; read(), write() [rt] by the loop's thread: no allocation, no lock, bounded (sub-steps
// of the mechanics are fixed). The accessors tell the truth behind the frames, for tests and summaries; same thread.
// Frame: the device's. Units: SI. Same arguments, same commands: the same bits.
#pragma once

#include <optional>

#include "firmware/device.h"
#include "hal/fault_injection.h"
#include "hal/frame_codec.h"
#include "hal/plant.h"
#include "hal/simulated_link.h"
#include "hal/told_idle.h"

namespace tactus::hal {

struct SimulationOptions {
  std::int64_t period_ns{1'000'000};              // one read() to the next, 50 us to 1 s
  unsigned sub_steps{4};                          // of the mechanics per period, 1 to 64
  std::optional<unsigned> transport_delay_ticks;  // 1 to 32; not given: the profile's
  std::uint64_t seed{1};                          // of the faults that are random
  FaultScript faults;
};

class SimulatedDevice {
 public:
  // [setup] The tool starts at rest in the hand, at the first pose of its path; the firmware has been told to be IDLE,
  // so that the first command that wants FORCE may have it. Check the options first.
  SimulatedDevice(const DeviceProfile& profile, HandModel hand, const SimulationOptions& options);

  // [setup] One line: which option is out of its range.
  static Status check(const SimulationOptions& options);

  const haptics::DeviceProperties& properties() const noexcept { return properties_; }
  void read(haptics::DeviceInput& input) noexcept;
  void write(const haptics::DeviceCommand& command) noexcept;

  // A new trial [rt]: the hand goes back to where its path starts and rests there; start_path() has it set out again,
  // `into_s` after the path's beginning. hand_is_back: what the way has shaken has died out.
  void return_hand() noexcept;
  bool hand_is_back() const noexcept;
  void start_path(double into_s) noexcept;

  // --- the truth
  std::uint64_t tick() const noexcept { return now_; }  // of the last read, from 0
  std::int64_t period_ns() const noexcept { return options_.period_ns; }
  const Plant& plant() const noexcept { return plant_; }
  const HandModel& hand() const noexcept { return hand_; }
  HandTarget hand_target() const noexcept { return target_at(now_, 0); }
  const firmware::Controller& controller() const noexcept { return device_.controller(); }
  const firmware::ControllerOutputs& motor_outputs() const noexcept { return outputs_; }  // in force until next read

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
  std::uint64_t hand_since_{0};  // tick at which the hand's path, or its way back, began
  double path_from_s_{0};        // of the path, at that tick
  bool hand_returns_{false};
  Posed return_from_;
  Plant plant_;
  firmware::Device device_;
  firmware::ControllerOutputs outputs_;
  FrameCodec codec_;
  SimulatedLink state_link_, command_link_;
  std::array<std::byte, firmware::kCommandFrameSize> waiting_command_{}, last_command_{};
  StateBytes last_state_{};
  haptics::DeviceSample sample_;  // the last one that came
  std::uint64_t reads_{0}, now_{0}, random_state_;
  bool command_waits_{false}, command_sent_{false}, state_sent_{false};
  std::uint8_t buttons_{0};
};

static_assert(haptics::HapticDevice<SimulatedDevice>);

}  // namespace tactus::hal
