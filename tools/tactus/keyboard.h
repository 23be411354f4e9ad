// The operator's requests at the terminal. Thread: main.
#pragma once

#include <cstdint>

namespace tactus::tools {

// OperatorBits of Enter (re-arm), or r and Enter (reset); none if standard input is closed or no terminal.
std::uint32_t asked_on_keyboard();

}  // namespace tactus::tools
