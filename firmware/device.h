// The device's whole program, without its board: the controller, and around it the registers, identity, homing, arm
// weight, thermal model, fault log and self-test.
//
// A step, in this order: take over what was written -> encoders -> what the rooms say (Supervision) -> Controller::step
// -> speeds, temperatures, log -> one row of the self-test and of a save under way.
// Thread: construction and restore() [setup]; the rest the control period's, [rt]: no heap, no lock, no exception,
// bounded. Units: SI. See board.h for the period, registers.h for what serve() answers.
#pragma once

#include "firmware/bus_errors.h"
#include "firmware/config_block.h"
#include "firmware/fault_log.h"
#include "firmware/identity.h"
#include "firmware/self_test.h"
#include "firmware/service.h"
#include "firmware/speed_filter.h"

namespace tactus::firmware {

// Numbers are those of the register save_state.
enum class SaveState : std::uint32_t {
  kNone = 0,
  kWriting = 1,  // the block is made, or waits for the board
  kSaved = 2,
  kFailed = 3,  // the board keeps nothing, or could not
};

class Device {
 public:
  // With every room but the controller neutral: no homing, no thermal model, no arm weight.
  explicit Device(const Config& config, const Identity& identity = {}) noexcept
      : Device(DeviceConfig{config, {}, {}, {}, {}}, identity) {}
  explicit Device(const DeviceConfig& factory, const Identity& identity = {}) noexcept;

  // [setup] Takes over what was saved. False, and the factory's configuration stays: the block is none (self-test bit
  // 5).
  bool restore(std::span<const std::byte> block) noexcept;

  // Once per control period; see Controller::step. The state frame tells counts after direction and offset.
  ControllerOutputs step(const ControllerInputs& inputs, std::span<const std::byte> command_frame) noexcept;
  // A frame that came since the last step, in the order of arrival; step() hears its own last.
  void hear(std::span<const std::byte> command_frame) noexcept { controller_.hear(command_frame); }

  // Answers one request. What it writes is in force from the next step on, whole.
  ServiceMessage serve(const ServiceMessage& request) noexcept;

  // What the link knows of its bus; registers read it. Ask it before every request.
  void note_bus_errors(const BusErrors& errors) noexcept { bus_errors_ = errors; }

  // A configuration that waits to be stored: ask after every step; empty if none does. Valid until stored() is told how
  // it went.
  std::span<const std::byte> block_to_store() const noexcept;
  void stored(bool good) noexcept;

  const Controller& controller() const noexcept { return controller_; }
  const Encoders& encoders() const noexcept { return encoders_; }
  const ThermalModel& thermal() const noexcept { return thermal_; }
  const AxisValues& speed() const noexcept { return speed_filter_.speed(); }  // smoothed
  const FaultLog& fault_log() const noexcept { return log_; }
  const SelfTest& self_test() const noexcept { return self_test_; }
  const DeviceConfig& config() const noexcept { return accepted_; }  // as written, in force from the next step on
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
  bool changed_{false};     // accepted_ is not yet in force
  bool rooms_valid_{true};  // what is in force makes sense beside the controller's part, which it judges itself
  Identity identity_;

  Encoders encoders_;
  Controller controller_;
  SpeedFilter speed_filter_;
  ThermalModel thermal_;
  GravityConfig gravity_;
  bool carries_arm_{false};  // some term of gravity_ is not zero
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
