#include "rt/text/read_file.h"

#include <fstream>

namespace tactus::text {

std::optional<std::string> read_file(const std::filesystem::path& path, std::size_t limit_bytes) {
  std::ifstream file(path, std::ios::binary);
  std::error_code none;
  if (!file || std::filesystem::is_directory(path, none)) return std::nullopt;
  std::string text(limit_bytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (file.bad()) return std::nullopt;
  text.resize(static_cast<std::size_t>(file.gcount()));
  return text;
}

}  // namespace tactus::text
