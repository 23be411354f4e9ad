// The Python module that the program hands work to. Thread: [setup].
#pragma once

#include <filesystem>

namespace tactus::tools {

inline constexpr const char* kPython = "/usr/bin/python3";  // Debian's, which the module is made for

// Where the module is: in the build folder or in the prefix of `program`. Empty: nowhere.
std::filesystem::path python_module_folder(const std::filesystem::path& program);

}  // namespace tactus::tools
