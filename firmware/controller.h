// The core of the device's program: one step per control period, from encoder counts and the received commands to motor
// efforts and the state frame to send. A board supplies the inputs and applies the outputs; this file depends on none.
//
// Thread: the control period's, [rt]: no heap, no lock, no exception, bounded work, float arithmetic. Units: N on
// prismatic axes (0 to 2), N m on rotary ones (3 to 5), SI elsewhere.
//
// The watchdog accepts a frame that decodes, has finite efforts, and is newer than the newest accepted one. Duplicates,
// older frames, corrupt frames and NaN do not count. If several arrive in one period, the newest by sequence is
// applied, in whatever order they arrived. After `brake_frames` periods without an accepted frame (in any state, also
// after start-up) the next one only starts a new sequence (if several arrive in that period, the last one) and has no
// other effect. So an old frame left in a buffer moves no motor, and a restarted host is accepted. The watchdog brakes
// in FORCE only; a device without commands is IDLE, which is no fault.
//
// FORCE is refused until a command has requested IDLE since start-up; the one that starts the sequence counts. So a
// device that is reset in mid-run applies no force for a host that did not notice and still requests FORCE.
//
// The modules around the controller (homing, temperature, self-test, the arm's weight) act through Supervision, passed
// by value once per period; the controller also works without it.
#pragma once

#include "firmware/faults.h"
#include "firmware/protocol.h"

namespace tactus::firmware {

using AxisValues = std::array<float, kAxes>;

struct Config {
  AxisValues quantum{};     // m or rad per count, > 0
  AxisValues max_effort{};  // N or N m, per motor; 0 for an axis without a motor
  AxisValues max_speed{};   // m/s or rad/s, per axis; above it: BRAKE
  float max_force_N{0};     // norm of axes 0 to 2
  float max_torque_Nm{0};   // norm of axes 3 to 5
  std::uint32_t period_us{1000};
  std::uint8_t fade_frames{3};    // consecutive missed commands from which the effort fades
  std::uint8_t brake_frames{10};  // consecutive missed commands that cause BRAKE
};

// All numbers finite and in range, fade_frames < brake_frames. With an invalid one the controller stays in RESET with a
// fault.
bool is_valid(const Config& config) noexcept;

struct ControllerInputs {
  AxisCounts counts{};
  std::uint64_t time_us{0};  // device clock, monotone
  std::uint8_t buttons{0};
  bool emergency_stop{false};  // its line is active
  bool motor_bus_ok{true};
  // Optional data of encoders and motors, for homing.h and thermal.h. Bit k is axis k.
  std::uint8_t index_edges{0};     // an index pulse occurred since the last sample
  std::uint8_t encoder_errors{0};  // line fault or impossible transition
  AxisCounts index_counts{};       // count latched at the newest index pulse, if there was one
  AxisValues measured_rise_K{};    // winding over ambient, from a sensor; 0 without one
};

// What the modules around the controller require in one period. Default: no effect.
struct Supervision {
  Fault fault{Fault::kNone};                  // a present cause for BRAKE
  bool force_allowed{true};                   // false: a command that requests FORCE is treated as requesting IDLE
  bool support_in_idle{false};                // `support` acts in IDLE too
  std::uint16_t limits{0};                    // bits to report in addition to the controller's own
  AxisValues effort_share{1, 1, 1, 1, 1, 1};  // fraction of each motor's max_effort, 0 to 1
  AxisValues support{};  // N, N m: carries the arm's weight; the command's efforts are added to it, within all limits
};

struct ControllerOutputs {
  AxisValues effort{};  // to the motors, until the next step
  bool brake{true};     // short the motors
  std::array<std::byte, kStateFrameSize> state_frame{};
};

// Events of a period, most urgent first; a step handles exactly one. See the table in controller.cpp.
enum class Event : std::uint8_t {
  kEmergencyStop = 0,
  kMotorBus = 1,
  kOverspeed = 2,
  kSupervision = 3,  // Supervision::fault
  kEffortNotFinite = 4,
  kCommandsLost = 5,
  kWantBrake = 6,
  kRearm = 7,  // rising edge of the flag, so that a stuck flag cannot defeat the latch
  kWantForce = 8,
  kWantIdle = 9,
  kNothing = 10,
};
inline constexpr unsigned kStates = 4, kEvents = 11;

// The complete state machine: a pure function.
State next_state(State state, Event event) noexcept;

// Fraction of the effort that is applied after `missed` consecutive missed commands: 1 before fade_frames, then linear
// from just below 1 to 0 at brake_frames.
float watchdog_share(std::uint32_t missed, const Config& config) noexcept;

class Controller {
 public:
  explicit Controller(const Config& config) noexcept;

  // Passes one frame received since the last step; call once per frame, in the order of arrival. Empty: no frame.
  void hear(std::span<const std::byte> command_frame) noexcept;
  // Once per control period. `command_frame`: one more frame, after all others; may be empty.
  ControllerOutputs step(const ControllerInputs& inputs, std::span<const std::byte> command_frame,
                         const Supervision& supervision = {}) noexcept;

  // Between two periods: the next step uses `config`. A valid one clears the fault of an invalid one.
  void configure(const Config& config) noexcept;
  // Between two periods, when direction or offset of the counts changed: the last reading after the change.
  void rebase(const AxisCounts& counts) noexcept { speed_meter_.rebase(counts); }

  const Config& config() const noexcept { return config_; }
  const AxisValues& speed() const noexcept { return speed_; }  // of this period, unfiltered; compared with max_speed
  State state() const noexcept { return state_; }
  Fault fault() const noexcept { return fault_; }
  std::uint16_t limits() const noexcept { return limits_; }
  std::uint32_t missed_commands() const noexcept { return missed_; }
  std::uint32_t refused_frames() const noexcept { return refused_; }  // corrupt, old or not finite; saturates
  DecodeError last_decode_error() const noexcept { return last_decode_error_; }

 private:
  // Result of the frames received since the last step.
  struct Heard {
    bool acceptable{false}, effort_not_finite{false};
    CommandFrame newest;
  };
  struct Reception {
    bool accepted{false}, effort_not_finite{false}, rearm_edge{false};
    State wanted{State::kIdle};
  };

  bool starts_sequence() const noexcept { return !sequence_known_ || missed_ >= config_.brake_frames; }
  Reception receive() noexcept;
  Event event_of(const ControllerInputs& inputs, const Reception& reception, const Supervision& supervision,
                 bool overspeed) const noexcept;
  void enter(State next, Event event, Fault supervision_fault) noexcept;
  AxisValues limited_effort(const Supervision& supervision) noexcept;
  AxisValues add_within_limits(const AxisValues& base, const AxisValues& extra, const AxisValues& share) noexcept;

  Config config_;
  bool config_valid_;
  State state_{State::kReset};
  Fault fault_{Fault::kNone};
  std::uint16_t limits_{0};
  AxisSpeed speed_meter_;
  AxisValues speed_{};
  Heard heard_;
  AxisValues commanded_{};  // N or N m: efforts of the newest accepted command
  std::uint32_t newest_command_{0};
  std::uint32_t missed_{0};  // consecutive periods without an accepted command; saturates
  bool sequence_known_{false};
  bool idle_wanted_{false};  // a command has requested IDLE since start-up
  bool rearm_before_{true};  // the flag must be received clear before an edge counts
  std::uint32_t refused_{0};
  DecodeError last_decode_error_{DecodeError::kNone};
  std::uint32_t state_sequence_{0};
};

}  // namespace tactus::firmware
