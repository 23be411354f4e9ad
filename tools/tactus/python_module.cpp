#include "tools/tactus/python_module.h"

namespace tactus::tools {
namespace {

bool has_module(const std::filesystem::path& folder) {
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "tactus", none))
    if (entry.path().filename().string().starts_with("_core.")) return true;
  return false;
}

}  // namespace

std::filesystem::path python_module_folder(const std::filesystem::path& program) {
  const std::filesystem::path prefix = program.parent_path().parent_path();
  for (const char* folder : {"python", "lib/python3/dist-packages"})
    if (has_module(prefix / folder)) return prefix / folder;
  return {};
}

}  // namespace tactus::tools
