// Two peripherals of Arm's CMSDK in the machine mps2-an386: a serial port and a watchdog. A port to a chip replaces
// this file and the interrupt numbers in main.cpp.
//
// Source: Cortex-M System Design Kit Technical Reference Manual (ARM DDI 0479), APB components; AN386, memory map and
// clock. Thread: [setup] and the interrupt handlers of main.cpp.
#pragma once

#include <cstdint>

#include "firmware/boards/cortex_m/cortex_m4.h"

namespace tactus::firmware::cortex_m {

inline constexpr std::uint32_t kCoreClock_Hz = 25'000'000;

struct UartRegisters {
  std::uint32_t volatile data;
  std::uint32_t volatile state;      // bit 0 transmitter full, bit 1 receiver full
  std::uint32_t volatile control;    // bits 0, 1 transmitter and receiver run; bits 2, 3 their interrupts
  std::uint32_t volatile interrupt;  // bit 0 transmitter, bit 1 receiver; writing a one clears it
  std::uint32_t volatile divider;    // core clock / bit rate, at least 16
};
inline constexpr std::uint32_t kUartTransmitterFull = 1, kUartReceiverFull = 2, kUartRuns = 0xf;
inline constexpr std::uint32_t kUartTransmitterInterrupt = 1, kUartReceiverInterrupt = 2;
inline constexpr unsigned kUart0ReceiverIrq = 0, kUart0TransmitterIrq = 1;

inline UartRegisters& uart0() noexcept { return *reinterpret_cast<UartRegisters*>(std::uintptr_t{0x40004000u}); }

inline void start_uart(UartRegisters& uart, std::uint32_t bit_rate_Hz) noexcept {
  uart.divider = kCoreClock_Hz / bit_rate_Hz;
  uart.control = kUartRuns;
}

// Counts down from `load`: reaching zero raises the NMI the first time, and resets the chip the second time.
struct WatchdogRegisters {
  std::uint32_t volatile load;
  std::uint32_t volatile value;
  std::uint32_t volatile control;          // bit 0 counts and interrupts, bit 1 resets
  std::uint32_t volatile clear_interrupt;  // any write restarts the count from `load`
};
inline constexpr std::uint32_t kWatchdogRuns = 3;

inline WatchdogRegisters& watchdog() noexcept {
  return *reinterpret_cast<WatchdogRegisters*>(std::uintptr_t{0x40008000u});
}

inline void start_watchdog(std::uint32_t timeout_us) noexcept {
  watchdog().load = timeout_us * (kCoreClock_Hz / 1'000'000);
  watchdog().control = kWatchdogRuns;
}
inline void kick_watchdog() noexcept { watchdog().clear_interrupt = 1; }

}  // namespace tactus::firmware::cortex_m
