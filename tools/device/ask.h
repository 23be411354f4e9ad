// Reads from a device on tactus' wire, one register after the other: all registers, its fault log, and the registers
// that a description needs.
//
// Thread: normal; no haptic loop uses the link meanwhile. Bound: kPatience for a reply; a device that stays busy is
// asked 200 times per register. Every function stops at the first register that gets no reply. Units: those of the
// registers.
#pragma once

#include <string>
#include <vector>

#include "hal/any_link.h"
#include "hal/profiles.h"
#include "tools/device/registers_text.h"

namespace tactus::device {

inline constexpr std::chrono::milliseconds kPatience{500};

struct RegisterValue {
  const firmware::Register* row{nullptr};
  unsigned index{0};
  std::uint32_t bits{0};
};

// Reads registers of a family. Error: no reply, or the device's refusal in words.
Result<std::vector<RegisterValue>> read_registers(hal::AnyLink& link, const RegisterName& name);

// All registers that can be read but the fault log's.
Result<std::vector<RegisterValue>> read_all(hal::AnyLink& link);

// Writes one register and returns what it then is; executes one that is a command.
Result<std::uint32_t> write_register(hal::AnyLink& link, const RegisterName& name, std::uint32_t bits);

// The entries of the fault log in words, the newest first.
Result<std::vector<std::string>> read_fault_log(hal::AnyLink& link);

// A register that a description needs: the value to write, and what a run accepts (hal/identity_check.h).
struct NeededRegister {
  RegisterValue value;
  double low{0}, high{0};
};

// Quanta, limits and watchdog that a description needs at this control period.
std::vector<NeededRegister> needed_registers(const hal::DeviceProfile& profile, std::uint32_t period_us);

bool satisfies(const NeededRegister& needed, std::uint32_t told);

// Writes those of `needed` that the device does not satisfy; how many it wrote. The description's limits may have to be
// written in an order that keeps the device's own checks: what is refused is tried again after the others, once.
Result<unsigned> write_needed(hal::AnyLink& link, const std::vector<NeededRegister>& needed);

}  // namespace tactus::device
