// The device's whole program, without its board: the controller, and around it the registers, identity, homing, arm
// weight, thermal model, fault log and self-test.
//
// A step, in this order: activate written configuration -> encoders -> Supervision from the modules -> Controller::step
// -> speeds, temperatures, log -> one row of the self-test and of a save in progress.
// Thread: construction and restore() [setup]; the rest the control period's, [rt]: no heap, no lock, no exception,
// bounded. Units: SI. See board.h for the period, registers.h for the registers that serve() accesses.
#pragma once

#include "firmware/bus_errors.h"
#include "firmware/config_block.h"
#include "firmware/fault_log.h"
#include "firmware/identity.h"
#include "firmware/self_test.h"
#include "firmware/service.h"
#include "firmware/speed_filter.h"

namespace tactus::firmware {

// Values of the register save_state.
enum class SaveState : std::uint32_t {
  kNone = 0,
  kWriting = 1,  // the block is being assembled, or waits for the board
  kSaved = 2,
  kFailed = 3,  // the board has no storage, or could not write
};

class Device {
 public:
  // With every module but the controller neutral: no homing, no thermal model, no arm weight.
  explicit Device(const Config& config, const Identity& identity = {}) noexcept
      : Device(DeviceConfig{.control = config, .encoders = {}, .thermal = {}, .gravity = {}, .bus = {}}, identity) {}
  explicit Device(const DeviceConfig& factory, const Identity& identity = {}) noexcept;

  // [setup] Activates a saved configuration. False if the block is empty, or invalid (which sets self-test bit 5): the
  // factory configuration stays active.
  bool restore(std::span<const std::byte> block) noexcept;

  // Once per control period; see Controller::step. The state frame contains counts after direction and offset.
  ControllerOutputs step(const ControllerInputs& inputs, std::span<const std::byte> command_frame) noexcept;
  // Passes a frame received since the last step, in the order of arrival; the argument of step() comes last.
  void hear(std::span<const std::byte> command_frame) noexcept { controller_.hear(command_frame); }

  // Replies to one request. Written values become active together, in the next step.
  ServiceMessage serve(const ServiceMessage& request) noexcept;

  // Error counters of the link's bus, for the registers. Call before every request.
  void note_bus_errors(const BusErrors& errors) noexcept { bus_errors_ = errors; }

  // A configuration that waits to be stored, to be polled after every step; empty if none. Valid until stored() reports
  // the result.
  std::span<const std::byte> block_to_store() const noexcept;
  void stored(bool good) noexcept;

  const Controller& controller() const noexcept { return controller_; }
  const Encoders& encoders() const noexcept { return encoders_; }
  const ThermalModel& thermal() const noexcept { return thermal_; }
  const AxisValues& speed() const noexcept { return speed_filter_.speed(); }  // smoothed
  const FaultLog& fault_log() const noexcept { return log_; }
  const SelfTest& self_test() const noexcept { return self_test_; }
  const DeviceConfig& config() const noexcept { return accepted_; }  // as written, active from the next step on
  const Identity& identity() const noexcept { return identity_; }

 private:
  void apply() noexcept;
  Supervision supervise(const Encoders::Reading& reading) noexcept;
  void log_fault(State before, Fault fault_before, const Encoders::Reading& reading) noexcept;
  ConfigView in_force() const noexcept;
  std::uint32_t read(const Register& row, unsigned index) const noexcept;
  std::uint32_t read_fault_log(unsigned index) const noexcept;
  ServiceStatus write(const Register& row, unsigned index, std::uint32_t value) noexcept;
  ServiceStatus execute(const Register& row, std::uint32_t argument) noexcept;

  DeviceConfig factory_, accepted_;
  bool changed_{false};     // accepted_ is not yet active
  bool parts_valid_{true};  // the active parts except the controller's, which the controller checks, are valid
  Identity identity_;

  Encoders encoders_;
  Controller controller_;
  SpeedFilter speed_filter_;
  ThermalModel thermal_;
  GravityConfig gravity_;
  bool carries_arm_{false};  // a term of gravity_ is not zero
  BusConfig bus_;
  BusErrors bus_errors_;
  FaultLog log_;
  SelfTest self_test_;
  bool stored_unreadable_{false};

  ConfigWriter writer_;
  SaveState save_state_{SaveState::kNone};
  bool block_waits_{false};
  std::uint64_t time_us_{0};
};

}  // namespace tactus::firmware
