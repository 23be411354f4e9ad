// Finds the files installed with the program: scenes and the page script. Their folder is relative to the program,
// PROGRAM/../../share/tactus; this works in the package, in another prefix, and in a build folder, which has links
// there. Thread: [setup]. Bound: none. Errors: none; the caller checks whether the file exists.
#pragma once

#include <filesystem>
#include <string>

namespace tactus::experiment {

inline std::filesystem::path shared_file(const std::string& name) {
  std::error_code none;  // without /proc the path is relative, and the file not found there
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", none);
  return program.parent_path().parent_path() / "share" / "tactus" / name;
}

}  // namespace tactus::experiment
