// Shared helpers of the readers of files in a scene. Thread: [setup].
#pragma once

#include <string>
#include <utility>

#include "rt/text/table_reader.h"

namespace tactus::sim {

inline constexpr double kFarthest_m = 1e3;  // limit on a corner's coordinates
inline constexpr text::Range kFileUnit{"a length of the file's unit", 1e-9, 1e3};
inline constexpr std::size_t kLongestFileName = 400;

// Splits "what; accepted: how" into its two halves.
inline std::pair<std::string, std::string> halves_of(const std::string& message) {
  constexpr std::string_view between = "; accepted: ";
  const std::size_t at = message.find(between);
  if (at == std::string::npos) return {message, ""};
  return {message.substr(0, at), message.substr(at + between.size())};
}

// The text as a TOML string.
inline std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + "\"";
}

}  // namespace tactus::sim
