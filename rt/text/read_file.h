// Reads a file that a user names, up to a limit. Thread: [setup].
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

namespace tactus::text {

// The file's bytes; of a file above the limit limit + 1 of them, so that the caller can refuse it. Empty: it cannot be
// read, or is a folder.
std::optional<std::string> read_file(const std::filesystem::path& path, std::size_t limit_bytes);

}  // namespace tactus::text
