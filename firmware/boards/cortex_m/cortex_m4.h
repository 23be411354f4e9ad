// The registers of the Cortex-M4 core that the program uses; chip-specific registers are in cmsdk.h.
//
// Addresses and bits: ARMv7-M Architecture Reference Manual (ARM DDI 0403), B3.2 (system control, coprocessor access),
// B3.3 (SysTick), B3.4 (NVIC). Thread: [setup] and [rt]; each register has one owner, see
// main.cpp.
#pragma once

#include <cstdint>

namespace tactus::firmware::cortex_m {

struct SysTickRegisters {
  std::uint32_t volatile control;  // bit 0 runs, bit 1 interrupts, bit 2 counts the core's clock
  std::uint32_t volatile reload;   // period - 1, 24 bits
  std::uint32_t volatile current;  // counts down; any write clears it
  std::uint32_t volatile calibration;
};
inline constexpr std::uint32_t kSysTickRuns = 7, kSysTickMaxReload = 0xffffff;

inline SysTickRegisters& systick() noexcept {
  return *reinterpret_cast<SysTickRegisters*>(std::uintptr_t{0xe000e010u});
}

inline std::uint32_t volatile& register_at(std::uint32_t address) noexcept {
  return *reinterpret_cast<std::uint32_t volatile*>(std::uintptr_t{address});
}

// Interrupts 0 to 31. The program sets one pending to start the transmitter's handler.
inline void enable_interrupt(unsigned number) noexcept { register_at(0xe000e100u) = 1u << number; }
inline void pend_interrupt(unsigned number) noexcept { register_at(0xe000e200u) = 1u << number; }

// Coprocessors 10 and 11 are the floating-point unit.
inline void enable_fpu() noexcept {
  register_at(0xe000ed88u) = register_at(0xe000ed88u) | (0xfu << 20);
  asm volatile("dsb\n isb" ::: "memory");
}

inline void disable_interrupts() noexcept { asm volatile("cpsid i" ::: "memory"); }
inline void enable_interrupts() noexcept { asm volatile("cpsie i" ::: "memory"); }
// Wakes at a pending interrupt, also while interrupts are disabled: so no interrupt is missed between check and sleep.
inline void wait_for_interrupt() noexcept { asm volatile("dsb\n wfi" ::: "memory"); }

}  // namespace tactus::firmware::cortex_m
