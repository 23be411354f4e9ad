// Start-up: the vector table, from reset to main(), and from unexpected exceptions to stop_after_fault().
//
// Thread: before all others. The stack lies at the bottom of the memory: if nothing is mapped below it, an overflow is
// a fault and not a corrupted variable. It is painted, so that its high-water mark can be read at any time.
#include "firmware/boards/cortex_m/startup.h"

#include "firmware/boards/cortex_m/cortex_m4.h"

using tactus::firmware::cortex_m::kStackPaint;

extern "C" {
// From the linker script.
extern std::uint32_t data_load_begin[], data_begin[], data_end[], bss_begin[], bss_end[];
extern void (*init_begin[])();
extern void (*init_end[])();

int main();

// Enables the FPU first: the compiler may use its registers from the first function on.
[[noreturn, gnu::used]] void start_program() {
  tactus::firmware::cortex_m::enable_fpu();
  std::uint32_t here;
  asm volatile("mov %0, sp" : "=r"(here));
  for (std::uint32_t* word = stack_limit; word < reinterpret_cast<std::uint32_t*>(here) - 1; ++word)
    *const_cast<std::uint32_t volatile*>(word) = kStackPaint;
  const std::uint32_t* from = data_load_begin;
  for (std::uint32_t* to = data_begin; to < data_end;) *to++ = *from++;
  for (std::uint32_t* to = bss_begin; to < bss_end;) *to++ = 0;
  for (void (**initialise)() = init_begin; initialise < init_end; ++initialise) (*initialise)();
  main();
  stop_after_fault(stack_top);
}

[[gnu::naked, gnu::used]] void on_reset() { asm volatile("b start_program"); }

// The stack may be corrupt: resets it to its top and passes the old pointer on.
[[gnu::naked, gnu::used]] void on_fault() noexcept {
  asm volatile(
      "mrs r0, msp\n"
      "ldr r1, =stack_top\n"
      "msr msp, r1\n"
      "b stop_after_fault\n");
}

// A program defines its own handlers under these names.
[[gnu::weak, gnu::alias("on_fault")]] void on_systick() noexcept;
[[gnu::weak, gnu::alias("on_fault")]] void on_uart0_receiver() noexcept;
[[gnu::weak, gnu::alias("on_fault")]] void on_uart0_transmitter() noexcept;
}

namespace {

struct VectorTable {
  const std::uint32_t* stack;
  void (*handlers[15 + 32])();  // exceptions 1 to 15, interrupts 0 to 31
};

constexpr VectorTable make_vectors() noexcept {
  VectorTable table{stack_top, {}};
  for (auto& handler : table.handlers) handler = on_fault;
  table.handlers[0] = on_reset;
  table.handlers[14] = on_systick;
  table.handlers[15] = on_uart0_receiver;
  table.handlers[16] = on_uart0_transmitter;
  return table;
}

[[gnu::section(".vectors"), gnu::used]] constinit const VectorTable kVectors = make_vectors();

}  // namespace
