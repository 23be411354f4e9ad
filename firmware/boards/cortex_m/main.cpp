// The device's program on a Cortex-M4: static objects, interrupt handlers, and the control loop.
//
// One control period per SysTick; between them the core sleeps. The handlers only move bytes and count ticks. All have
// the same priority: no handler interrupts another, except the faults and the watchdog's NMI.
#include "firmware/boards/cortex_m/board_mechanics.h"
#include "firmware/boards/cortex_m/board_storage.h"
#include "firmware/boards/cortex_m/cmsdk.h"
#include "firmware/boards/cortex_m/configuration.h"
#include "firmware/boards/cortex_m/serial_link.h"
#include "firmware/boards/cortex_m/startup.h"

using namespace tactus::firmware;
using namespace tactus::firmware::cortex_m;

// From the linker script.
extern "C" {
extern BoardRegisters board_registers;
extern StorageMemory storage_memory;
}

namespace {

struct Uart0 {
  void transmit() noexcept { pend_interrupt(kUart0TransmitterIrq); }
};

constinit PeriodClock period_clock;
constinit Uart0 port;
constinit SerialLink<Uart0> serial_link{port};
static_assert(DeviceLink<SerialLink<Uart0>>);

void sleep_until_next_tick() noexcept {
  for (;;) {
    disable_interrupts();
    const bool due = period_clock.take_tick();
    if (!due) wait_for_interrupt();
    enable_interrupts();
    if (due) return;
  }
}

}  // namespace

extern "C" {

void on_systick() { period_clock.tick(); }

void on_uart0_receiver() {
  UartRegisters& uart = uart0();
  uart.interrupt = kUartReceiverInterrupt;
  while ((uart.state & kUartReceiverFull) != 0) serial_link.received(static_cast<std::byte>(uart.data));
}

// Runs when a byte has been sent, and when the link has new bytes.
void on_uart0_transmitter() {
  UartRegisters& uart = uart0();
  uart.interrupt = kUartTransmitterInterrupt;
  std::byte b{};
  while ((uart.state & kUartTransmitterFull) == 0 && serial_link.next_to_send(b))
    uart.data = std::to_integer<std::uint32_t>(b);
}

// Shorts the motors and stops. The watchdog is no longer kicked: its NMI calls this once more, then it resets the chip.
// Only the first call records the program counter.
[[noreturn]] void stop_after_fault(const std::uint32_t* frame) {
  short_motors(board_registers);
  static bool stopped = false;
  constexpr unsigned program_count = 6;  // index among the eight words that an exception pushes on the stack
  if (!stopped) {
    const bool on_stack = frame >= stack_limit && frame + program_count < stack_top;
    board_registers.fault_program_count = on_stack ? frame[program_count] : kUnknownPlace;
  }
  stopped = true;
  for (;;) {}
}

int main() {
  short_motors(board_registers);
  constexpr Config configuration = make_configuration();
  static Device device(configuration, kIdentity);
  static BoardMechanics mechanics(board_registers, period_clock, kFullEffort);
  static BoardStorage storage(storage_memory);
  (void)restore_configuration(device, storage);  // an invalid one is reported in the self-test's register

  start_watchdog(kWatchdogTimeout_us);
  start_uart(uart0(), kSerialBitRate_Hz);
  enable_interrupt(kUart0ReceiverIrq);
  enable_interrupt(kUart0TransmitterIrq);
  if (!period_clock.start(systick(), kCoreClock_Hz, configuration.period_us)) return 1;
  while (stack_is_intact()) {
    sleep_until_next_tick();
    run_period(device, mechanics, serial_link, storage);
    kick_watchdog();
  }
  return 1;  // stack overflow: startup.cpp treats the return as a fault
}
}
