// What startup.cpp and the programs that it starts know of each other.
//
// Thread: see each. Units: 32-bit words. The symbols are the linker script's.
#pragma once

#include <cstddef>
#include <cstdint>

namespace tactus::firmware::cortex_m {
inline constexpr std::uint32_t kStackPaint = 0x5afe57acu;
}

extern "C" {
extern std::uint32_t stack_limit[], stack_top[];

// [any] Every fault, NMI and interrupt that nobody expects ends here, on a stack of its own beginning; `frame`: where
// the stack pointer was. Supplied by the program: makes the board safe and does not return.
[[noreturn]] void stop_after_fault(const std::uint32_t* frame);
}

namespace tactus::firmware::cortex_m {

// [rt] Has the stack been used up to its last word?
inline bool stack_is_intact() noexcept {
  return *const_cast<const std::uint32_t volatile*>(stack_limit) == kStackPaint;
}

// [setup] The most bytes of the stack that were ever in use.
inline std::size_t stack_high_water() noexcept {
  const std::uint32_t* word = stack_limit;
  while (word < stack_top && *const_cast<const std::uint32_t volatile*>(word) == kStackPaint) ++word;
  return static_cast<std::size_t>(stack_top - word) * sizeof(std::uint32_t);
}

}  // namespace tactus::firmware::cortex_m
