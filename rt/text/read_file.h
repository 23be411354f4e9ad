// Reads a file, up to a limit. A failed read returns an empty result; with std::istreambuf_iterator it would throw.
// Reads from /proc fail when the process or thread has ended meanwhile. Thread: [setup].
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

namespace tactus::text {

// Returns the file's bytes, or the first `limit_bytes` + 1 bytes of a larger file, so that the caller can refuse it.
// Empty: the file cannot be read, or is a folder.
std::optional<std::string> read_file(const std::filesystem::path& path, std::size_t limit_bytes);

}  // namespace tactus::text
