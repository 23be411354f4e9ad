#include "tools/device/ask.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <limits>
#include <thread>

#include "hal/identity_check.h"

namespace tactus::device {
namespace {

using firmware::Access;
using firmware::Operation;
using firmware::Register;
using firmware::ServiceStatus;

constexpr unsigned kBusyTries = 200;
constexpr std::chrono::milliseconds kBusyPause{2};

const char* words_of(ServiceStatus status) noexcept {
  switch (status) {
    case ServiceStatus::kNoSuchRegister:
      return "its firmware has no such register; update it";
    case ServiceStatus::kReadOnly:
      return "it is read only";
    case ServiceStatus::kOutOfRange:
      return "the value is out of range, or does not go with another register";
    case ServiceStatus::kWrongState:
      return "not in this state; end the run that drives it, so that the device is in IDLE or BRAKE";
    case ServiceStatus::kNoSuchOperation:
      return "that cannot be done with it";
    default:
      return "the device stays busy";
  }
}

// Asks again while the device is busy: a write takes effect one period later, a save after some fifty.
Result<std::uint32_t> ask(hal::AnyLink& link, Operation operation, const Register& row, unsigned index,
                          std::uint32_t value) {
  const auto number = static_cast<std::uint16_t>(row.number + index);
  ServiceStatus status = ServiceStatus::kBusy;
  std::array<std::byte, firmware::kMaxFrameSize> dropped;
  for (unsigned i = 0; i < kBusyTries; ++i) {
    const auto tag = static_cast<std::uint8_t>(i + 1);
    const auto reply = link.call(
        {.operation = operation, .status = ServiceStatus::kGood, .tag = tag, .address = number, .value = value},
        kPatience);
    if (!reply.ok()) return Status::error(fmt::format("{}: {}", name_of(row, index), reply.message()));
    status = reply.value().status;
    if (status == ServiceStatus::kGood) return reply.value().value;
    if (status != ServiceStatus::kBusy) break;
    std::this_thread::sleep_for(kBusyPause);
    (void)link.receive(dropped);  // also advances a device in this process by one period
  }
  return Status::error(fmt::format("{}: refused: {}", name_of(row, index), words_of(status)));
}

double number_of(const Register& row, std::uint32_t bits) noexcept {
  if (row.type == firmware::RegisterType::kF32) return static_cast<double>(std::bit_cast<float>(bits));
  if (row.type == firmware::RegisterType::kI32) return std::bit_cast<std::int32_t>(bits);
  return bits;
}

}  // namespace

Result<std::vector<RegisterValue>> read_registers(hal::AnyLink& link, const RegisterName& name) {
  std::vector<RegisterValue> values;
  for (unsigned i = 0; i < name.count; ++i) {
    const auto value = ask(link, Operation::kRead, *name.row, name.first + i, 0);
    if (!value.ok()) return value.status();
    values.push_back({name.row, name.first + i, value.value()});
  }
  return values;
}

Result<std::vector<RegisterValue>> read_all(hal::AnyLink& link) {
  std::vector<RegisterValue> all;
  for (const Register& row : firmware::all_registers()) {
    if (row.access == Access::kCommand || row.number == firmware::number::kFaultLog) continue;
    const auto values = read_registers(link, {&row, 0, row.count});
    if (!values.ok()) return values.status();
    all.insert(all.end(), values.value().begin(), values.value().end());
  }
  return all;
}

Result<std::uint32_t> write_register(hal::AnyLink& link, const RegisterName& name, std::uint32_t bits) {
  const Operation operation = name.row->access == Access::kCommand ? Operation::kExecute : Operation::kWrite;
  return ask(link, operation, *name.row, name.first, bits);
}

Result<std::vector<std::string>> read_fault_log(hal::AnyLink& link) {
  const Register& row = *firmware::find_register(firmware::number::kFaultLog);
  std::vector<std::string> entries;
  for (unsigned first = 0; first + firmware::kFaultLogWords <= row.count; first += firmware::kFaultLogWords) {
    std::uint32_t words[firmware::kFaultLogWords];
    for (unsigned w = 0; w < firmware::kFaultLogWords; ++w) {
      const auto value = ask(link, Operation::kRead, row, first + w, 0);
      if (!value.ok()) return value.status();
      words[w] = value.value();
    }
    std::string text = fault_entry_text(words);
    if (text.empty()) break;
    entries.push_back(std::move(text));
  }
  return entries;
}

std::vector<NeededRegister> needed_registers(const hal::DeviceProfile& profile, std::uint32_t period_us) {
  namespace number = firmware::number;
  constexpr double kAny = std::numeric_limits<double>::max();
  firmware::DeviceConfig config;
  config.control = hal::firmware_config(profile, period_us);
  const hal::AxisKinds kinds = hal::axes_of(profile.description.kind);
  std::vector<NeededRegister> needed;
  const auto add = [&](std::uint16_t first, unsigned index) -> NeededRegister& {
    const Register& row = *firmware::find_register(first);
    const std::uint32_t bits = first == number::kPeriod ? period_us : firmware::read_field(row, index, config.view());
    const double value = number_of(row, bits);
    return needed.emplace_back(NeededRegister{{&row, index, bits}, value, value});
  };
  const auto add_limit = [&](std::uint16_t first, unsigned index) {
    NeededRegister& one = add(first, index);
    one.low = one.low / hal::kFirmwareMargin * (1 - hal::kLimitTolerance);
    one.high = one.high / hal::kFirmwareMargin * hal::kMaxSpareEffort;
  };
  for (unsigned axis = 0; axis < kinds.prismatic + kinds.rotary; ++axis) {
    NeededRegister& quantum = add(number::kQuantum, axis);
    quantum.low *= 1 - hal::kQuantumTolerance;
    quantum.high *= 1 + hal::kQuantumTolerance;
    add_limit(number::kMaxEffort, axis);
    NeededRegister& speed = add(number::kMaxSpeed, axis);
    speed.low = profile.bounds.rate[axis] * (1 - hal::kLimitTolerance);
    speed.high = kAny;
  }
  add_limit(number::kMaxForce, 0);
  if (profile.description.has_rotation()) add_limit(number::kMaxTorque, 0);
  for (const std::uint16_t whole : {number::kPeriod, number::kFadeFrames, number::kBrakeFrames}) add(whole, 0);
  return needed;
}

bool satisfies(const NeededRegister& needed, std::uint32_t told) {
  const double value = number_of(*needed.value.row, told);
  return value >= needed.low && value <= needed.high;
}

Result<unsigned> write_needed(hal::AnyLink& link, const std::vector<NeededRegister>& needed) {
  unsigned written = 0;
  std::vector<NeededRegister> left = needed;
  for (unsigned pass = 0; pass < 2 && !left.empty(); ++pass) {
    std::vector<NeededRegister> again;
    for (const NeededRegister& one : left) {
      const RegisterValue& value = one.value;
      const auto told = ask(link, Operation::kRead, *value.row, value.index, 0);
      if (!told.ok()) return told.status();
      if (satisfies(one, told.value())) continue;
      const auto wrote = ask(link, Operation::kWrite, *value.row, value.index, value.bits);
      if (wrote.ok())
        ++written;
      else if (pass == 0)
        again.push_back(one);
      else
        return wrote.status();
    }
    left = std::move(again);
  }
  return written;
}

}  // namespace tactus::device
