// Service requests of Device: reading and writing registers, executing commands.
#include "firmware/device.h"

namespace tactus::firmware {
namespace {

template <class Enum>
std::uint32_t to_value(Enum e) noexcept {
  return static_cast<std::uint32_t>(e);
}

}  // namespace

ServiceMessage Device::serve(const ServiceMessage& request) noexcept {
  ServiceMessage reply = request;
  const Register* row = find_register(request.address);
  if (row == nullptr) {
    reply.status = ServiceStatus::kNoSuchRegister;
    return reply;
  }
  const auto index = static_cast<unsigned>(request.address - row->number);
  const bool is_command = row->access == Access::kCommand;
  reply.status = ServiceStatus::kNoSuchOperation;
  switch (request.operation) {
    case Operation::kRead:
      reply.status = ServiceStatus::kGood;
      break;
    case Operation::kWrite:
      if (!is_command) reply.status = write(*row, index, request.value);
      break;
    case Operation::kExecute:
      if (is_command) reply.status = execute(*row, request.value);
      break;
  }
  if (reply.status == ServiceStatus::kGood) reply.value = read(*row, index);
  return reply;
}

ServiceStatus Device::write(const Register& row, unsigned index, std::uint32_t value) noexcept {
  if (row.access != Access::kReadWrite) return ServiceStatus::kReadOnly;
  if (((row.states >> to_value(controller_.state())) & 1u) == 0) return ServiceStatus::kWrongState;
  const bool homing = encoders_.state() == HomingState::kHoming;
  if (save_state_ == SaveState::kWriting || homing) return ServiceStatus::kBusy;
  if (!is_in_range(row, value)) return ServiceStatus::kOutOfRange;

  // A valid configuration must stay valid; an invalid one may be repaired register by register.
  const bool was_valid = is_valid(accepted_);
  const std::uint32_t before = read_field(row, index, accepted_.view());
  write_field(row, index, value, accepted_);
  if (was_valid && !is_valid(accepted_)) {
    write_field(row, index, before, accepted_);
    return ServiceStatus::kOutOfRange;
  }
  changed_ = true;
  return ServiceStatus::kGood;
}

ServiceStatus Device::execute(const Register& row, std::uint32_t argument) noexcept {
  if (((row.states >> to_value(controller_.state())) & 1u) == 0) return ServiceStatus::kWrongState;
  if (!is_in_range(row, argument)) return ServiceStatus::kOutOfRange;
  if (save_state_ == SaveState::kWriting) return ServiceStatus::kBusy;
  const bool homing = encoders_.state() == HomingState::kHoming;
  switch (row.number) {
    case number::kSave:
      if (changed_ || homing) return ServiceStatus::kBusy;  // a change becomes active in the next period
      writer_.begin();
      save_state_ = SaveState::kWriting;
      return ServiceStatus::kGood;
    case number::kFactory:
      if (homing) return ServiceStatus::kBusy;
      accepted_ = factory_;
      changed_ = true;
      return ServiceStatus::kGood;
    case number::kHome:
      if (changed_) return ServiceStatus::kBusy;
      return encoders_.order(static_cast<HomingOrder>(argument)) ? ServiceStatus::kGood : ServiceStatus::kOutOfRange;
    case number::kSelfTest:
      self_test_.start();
      return ServiceStatus::kGood;
    default:
      return ServiceStatus::kNoSuchOperation;
  }
}

std::uint32_t Device::read(const Register& row, unsigned index) const noexcept {
  using namespace number;
  if (row.section != Section::kNone) return read_field(row, index, accepted_.view());
  switch (row.number) {
    case kProtocol:
      return kProtocolVersion;
    case kRevision:
      return kRegisterRevision;
    case kFirmware:
      return kFirmwareVersion;
    case kDeviceClass:
      return to_value(identity_.device_class);
    case kAxisCount:
      return kAxes;
    case kSerial:
      return serial_word(identity_, index);
    case kPeriod:
      return accepted_.control.period_us;
    case kState:
      return to_value(controller_.state());
    case kFault:
      return to_value(controller_.fault());
    case kLimits:
      return controller_.limits();
    case kMissedCommands:
      return controller_.missed_commands();
    case kRefusedFrames:
      return controller_.refused_frames();
    case kDecodeError:
      return to_value(controller_.last_decode_error());
    case kHomingState:
      return to_value(encoders_.state());
    case kHomedAxes:
      return encoders_.homed_axes();
    case kSelfTestFailed:
      return self_test_.failed() | (stored_unreadable_ ? to_value(SelfTestBit::kStoredConfiguration) : 0u);
    case kSelfTestPasses:
      return self_test_.passes();
    case kUptime:
      return static_cast<std::uint32_t>(time_us_ / 1'000'000u);
    case kSaveState:
      return to_value(save_state_);
    case kFaultTotal:
      return log_.total();
    case kEncoderErrors:
      return encoders_.errors(index);
    case kSpeed:
      return std::bit_cast<std::uint32_t>(speed()[index]);
    case kWindingRise:
      return std::bit_cast<std::uint32_t>(thermal_.rise_K()[index]);
    case kEffortShare:
      return std::bit_cast<std::uint32_t>(thermal_.effort_share()[index]);
    case kCanTransmitErrors:
      return bus_errors_.transmit;
    case kCanReceiveErrors:
      return bus_errors_.receive;
    case kCanBusOff:
      return bus_errors_.bus_off;
    case kFaultLog:
      return read_fault_log(index);
    default:
      return 0;  // a command register
  }
}

// Word index % 4 of entry index / 4; entry 0 is the newest.
std::uint32_t Device::read_fault_log(unsigned index) const noexcept {
  const FaultEntry entry = log_.entry(index / kFaultLogWords);
  switch (index % kFaultLogWords) {
    case 0:
      return to_value(entry.fault) | (to_value(entry.state_before) << 16) | (std::uint32_t{entry.axis} << 24);
    case 1:
      return static_cast<std::uint32_t>(entry.time_us);
    case 2:
      return static_cast<std::uint32_t>(entry.time_us >> 32);
    default:
      return std::bit_cast<std::uint32_t>(entry.value);
  }
}

}  // namespace tactus::firmware
