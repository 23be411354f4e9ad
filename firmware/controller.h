// The core of the device's program: one step per control period, from encoder counts and the command that came to motor
// efforts and the state frame to send. A board supplies the inputs and carries out the outputs; nothing here knows one.
//
// Thread: the control period's, [rt]: no heap, no lock, no exception, bounded work, float arithmetic. Units: N on
// prismatic axes (0 to 2), N m on rotary ones (3 to 5), SI elsewhere.
//
// Which frames feed the watchdog: those that decode, carry finite efforts, and are newer than the newest accepted one.
// Duplicates, late-comers, broken frames and NaN do not. Of several in one period the newest by sequence is obeyed,
// whatever came after it. After `brake_frames` periods without such a frame (in any state, so also at start) the next
// one only starts a new sequence (of several in that period the last that came): it is obeyed in nothing but that, so
// that an old frame left in a buffer moves no motor and a host that starts afresh is understood. The watchdog brakes in
// FORCE only; a device that nobody commands is IDLE, not broken.
//
// FORCE is refused until a command has wanted IDLE since the start, be it the one that starts the sequence: a device
// that is reset in mid-run gives no force to a host that noticed nothing and goes on wanting FORCE.
//
// What the rooms around the controller know (homing, temperature, self-test, the arm's weight) comes in as Supervision,
// by value, once per period; a controller that gets none is complete without it.
#pragma once

#include "firmware/faults.h"
#include "firmware/protocol.h"

namespace tactus::firmware {

using AxisValues = std::array<float, kAxes>;

struct Config {
  AxisValues quantum{};     // m or rad per count, > 0
  AxisValues max_effort{};  // N or N m, per motor; 0 for an axis without one
  AxisValues max_speed{};   // m/s or rad/s, per axis; beyond: BRAKE
  float max_force_N{0};     // norm of axes 0 to 2
  float max_torque_Nm{0};   // norm of axes 3 to 5
  std::uint32_t period_us{1000};
  std::uint8_t fade_frames{3};    // missed in a row: the effort fades
  std::uint8_t brake_frames{10};  // missed in a row: BRAKE
};

// All numbers finite and in range, fade before brake. A controller with a bad one stays in RESET with a fault.
bool is_valid(const Config& config) noexcept;

struct ControllerInputs {
  AxisCounts counts{};
  std::uint64_t time_us{0};  // device clock, monotone
  std::uint8_t buttons{0};
  bool stop_line{false};  // the e-stop line is active
  bool motor_bus_ok{true};
  // What better encoders and motors tell as well; for encoders.h and thermal.h. Bit k is axis k.
  std::uint8_t index_edges{0};     // an index pulse came since the last sample
  std::uint8_t encoder_errors{0};  // line fault, or a transition that cannot be
  AxisCounts index_counts{};       // the count latched at the newest pulse, where there was one
  AxisValues measured_rise_K{};    // winding over ambient, from a sensor; 0 without one
};

// One period's verdict of the rooms around the controller. By default: nothing to say.
struct Supervision {
  Fault fault{Fault::kNone};                  // a cause for BRAKE, there now
  bool force_allowed{true};                   // false: a command that wants FORCE counts as one that wants IDLE
  bool support_in_idle{false};                // `support` acts in IDLE too
  std::uint16_t limits{0};                    // bits to report beside the controller's own
  AxisValues effort_share{1, 1, 1, 1, 1, 1};  // of each motor's max_effort, 0 to 1
  AxisValues support{};  // N, N m: carries the arm, beneath the command's efforts; inside all limits
};

struct ControllerOutputs {
  AxisValues effort{};  // to the motors, until the next step
  bool brake{true};     // short the motors
  std::array<std::byte, kStateFrameSize> state_frame{};
};

// What a period brings, most urgent first; a step handles exactly one. See the table in controller.cpp.
enum class Event : std::uint8_t {
  kStopLine = 0,
  kMotorBus = 1,
  kOverspeed = 2,
  kSupervision = 3,  // Supervision::fault
  kEffortNotFinite = 4,
  kCommandsLost = 5,
  kWantBrake = 6,
  kRearm = 7,  // rising edge of the flag: one that is stuck cannot defeat the latch
  kWantForce = 8,
  kWantIdle = 9,
  kNothing = 10,
};
inline constexpr unsigned kStates = 4, kEvents = 11;

// The whole state machine: a pure function.
State next_state(State state, Event event) noexcept;

// The share of the effort that is left with so many commands missed in a row: 1 before fade_frames, then linear from
// just below 1 to 0 at brake_frames.
float watchdog_share(std::uint32_t missed, const Config& config) noexcept;

class Controller {
 public:
  explicit Controller(const Config& config) noexcept;

  // A frame that came since the last step, in the order of arrival; as often as frames came. Empty: none.
  void hear(std::span<const std::byte> command_frame) noexcept;
  // Once per control period. `command_frame`: heard too, after all others; may be empty.
  ControllerOutputs step(const ControllerInputs& inputs, std::span<const std::byte> command_frame,
                         const Supervision& supervision = {}) noexcept;

  // Between two periods: the next step runs with `config`. A device that waited for a good one stops waiting.
  void configure(const Config& config) noexcept;
  // Between two periods, when the meaning of counts changed: what the last reading is in the new meaning.
  void rebase(const AxisCounts& counts) noexcept { speed_meter_.rebase(counts); }

  const Config& config() const noexcept { return config_; }
  const AxisValues& speed() const noexcept { return speed_; }  // of this period, unfiltered; what overspeed looks at
  State state() const noexcept { return state_; }
  Fault fault() const noexcept { return fault_; }
  std::uint16_t limits() const noexcept { return limits_; }
  std::uint32_t missed_commands() const noexcept { return missed_; }
  std::uint32_t refused_frames() const noexcept { return refused_; }  // broken, old or not finite; saturates
  DecodeError last_decode_error() const noexcept { return last_decode_error_; }

 private:
  // Of the frames heard since the last step.
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
  AxisValues commanded_{};  // of the newest accepted command
  std::uint32_t newest_command_{0};
  std::uint32_t missed_{0};  // periods in a row without an accepted command; saturates
  bool sequence_known_{false};
  bool idle_wanted_{false};  // by a command since the start
  bool rearm_before_{true};  // the flag must be seen clear before it counts
  std::uint32_t refused_{0};
  DecodeError last_decode_error_{DecodeError::kNone};
  std::uint32_t state_sequence_{0};
};

}  // namespace tactus::firmware
