// A test program's way out of QEMU: its exit status, over semihosting.
//
// Thread: [any]. Bound: only under a debugger or an emulator; on a bare chip the instruction is a fault.
// Source: Semihosting for AArch32 and AArch64 (Arm), SYS_EXIT_EXTENDED.
#pragma once

#include <cstdint>

namespace tactus::firmware::cortex_m {

[[noreturn]] inline void exit_emulator(std::uint32_t status) noexcept {
  const std::uint32_t block[2]{0x20026, status};  // ADP_Stopped_ApplicationExit
  for (;;) {
    register std::uint32_t operation asm("r0") = 0x20;
    register const std::uint32_t* parameter asm("r1") = block;
    asm volatile("bkpt 0xab" : "+r"(operation) : "r"(parameter) : "memory");
  }
}

}  // namespace tactus::firmware::cortex_m
