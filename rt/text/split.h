// Splits a list in one word, such as "can0,can1", into its parts. Thread: [setup]; allocates.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tactus::text {

// The parts between the separators, one more than there are separators; a part may be empty.
inline std::vector<std::string> split(std::string_view list, char separator) {
  std::vector<std::string> parts;
  for (;;) {
    const std::size_t end = list.find(separator);
    parts.emplace_back(list.substr(0, end));
    if (end == std::string_view::npos) return parts;
    list.remove_prefix(end + 1);
  }
}

}  // namespace tactus::text
