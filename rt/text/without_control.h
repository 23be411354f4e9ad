// Replaces control characters in a text for messages: a file's name or key may contain them, and a terminal would
// execute them. Thread: any. Bound: the text.
#pragma once

#include <algorithm>
#include <string>

namespace tactus::text {

// Replaces every control character except `kept` by '?'.
inline std::string without_control(std::string text, char kept = '?') {
  const auto is_control = [kept](char c) { return (static_cast<unsigned char>(c) < 32 || c == 127) && c != kept; };
  std::replace_if(text.begin(), text.end(), is_control, '?');
  return text;
}

}  // namespace tactus::text
