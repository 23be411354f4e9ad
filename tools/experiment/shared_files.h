// Where the files are that come with the program: scenes, and what draws pages. They are found from the program's own
// place, PROGRAM/../../share/tactus: so in the package, in another prefix, and in a build folder, which has links
// there. Thread: [setup]. Bound: none. Errors: none; whether the file is there is for the caller to see.
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
