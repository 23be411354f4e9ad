// Escapes text from outside, such as a serial number, so that it is safe in a terminal, a log and JSON.
//
// Thread: [any] normal. Bound: linear.
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>

namespace tactus::hal {

// Every byte that is not printable ASCII, and the backslash, as \xNN.
inline std::string printable(std::string_view text) {
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte >= 0x20 && byte < 0x7f && c != '\\')
      out += c;
    else
      out += fmt::format("\\x{:02x}", byte);
  }
  return out;
}

}  // namespace tactus::hal
