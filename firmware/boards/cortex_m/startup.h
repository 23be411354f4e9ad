// Interface between startup.cpp and the programs that it starts: fault handler and stack checks.
//
// Thread: see each function. Units: 32-bit words. The symbols are defined in the linker script.
#pragma once

#include <cstddef>
#include <cstdint>

namespace tactus::firmware::cortex_m {
inline constexpr std::uint32_t kStackPaint = 0x5afe57acu;
}

extern "C" {
extern std::uint32_t stack_limit[], stack_top[];

// [any] Called for every fault, NMI and unexpected interrupt, with the stack reset to its top; `frame`: the previous
// stack pointer. Defined by the program: makes the board safe and does not return.
[[noreturn]] void stop_after_fault(const std::uint32_t* frame);
}

namespace tactus::firmware::cortex_m {

// [rt] False if the last word of the stack has been overwritten.
inline bool stack_is_intact() noexcept {
  return *const_cast<const std::uint32_t volatile*>(stack_limit) == kStackPaint;
}

// [setup] High-water mark of the stack, bytes.
inline std::size_t stack_high_water() noexcept {
  const std::uint32_t* word = stack_limit;
  while (word < stack_top && *const_cast<const std::uint32_t volatile*>(word) == kStackPaint) ++word;
  return static_cast<std::size_t>(stack_top - word) * sizeof(std::uint32_t);
}

}  // namespace tactus::firmware::cortex_m
