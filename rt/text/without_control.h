// What a file's name or key may hold and a terminal would obey. Thread: any. Bound: the text.
#pragma once

#include <algorithm>
#include <string>

namespace tactus::text {

// Control characters as '?', but `kept`.
inline std::string without_control(std::string text, char kept = '?') {
  const auto is_control = [kept](char c) { return (static_cast<unsigned char>(c) < 32 || c == 127) && c != kept; };
  std::replace_if(text.begin(), text.end(), is_control, '?');
  return text;
}

}  // namespace tactus::text
