#include "rt/text/read_file.h"

#include <algorithm>
#include <array>
#include <fstream>

namespace tactus::text {

std::optional<std::string> read_file(const std::filesystem::path& path, std::size_t limit_bytes) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return std::nullopt;
  std::string text;
  std::array<char, 16'384> part;
  while (file && text.size() <= limit_bytes) {
    file.read(part.data(), static_cast<std::streamsize>(std::min(part.size(), limit_bytes + 1 - text.size())));
    text.append(part.data(), static_cast<std::size_t>(file.gcount()));
  }
  if (file.bad()) return std::nullopt;  // of a folder too: it opens, and cannot be read
  return text;
}

}  // namespace tactus::text
