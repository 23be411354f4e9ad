// Reads a file, up to a limit. A read that fails does not throw, as it does with std::istreambuf_iterator: the files of
// /proc fail when their process or thread has ended meanwhile. Thread: [setup].
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
