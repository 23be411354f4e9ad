#include "hal/sdk/shared_library.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace tactus::hal {
namespace {

namespace fs = std::filesystem;

// The place of a file among the names; names.size(): none of them.
std::size_t rank_of(const fs::path& path, const std::vector<std::string>& names) {
  const std::string name = path.filename().string();
  const auto found = std::find_if(names.begin(), names.end(), [&](const auto& n) { return name.starts_with(n); });
  return static_cast<std::size_t>(found - names.begin());
}

// The libraries in a folder and in its places: the best name first, then the newest version.
void add_libraries_of(const fs::path& folder, const LibrarySearch& search, std::vector<fs::path>& found) {
  std::vector<fs::path> places{folder}, here;
  for (const std::string& below : search.below) places.push_back(folder / below);
  std::error_code error;
  for (const fs::path& place : places)
    for (const auto& entry : fs::directory_iterator(place, error))
      if (rank_of(entry.path(), search.names) < search.names.size()) here.push_back(entry.path());
  std::sort(here.begin(), here.end(), [&](const fs::path& a, const fs::path& b) {
    const std::size_t rank_a = rank_of(a, search.names), rank_b = rank_of(b, search.names);
    return rank_a != rank_b ? rank_a < rank_b : a.filename() > b.filename();
  });
  found.insert(found.end(), here.begin(), here.end());
}

std::vector<fs::path> candidates(const LibrarySearch& search, const fs::path& given) {
  std::vector<fs::path> found;
  std::error_code error;
  if (!given.empty() && !fs::is_directory(given, error)) return {given};
  if (!given.empty()) {
    add_libraries_of(given, search, found);
    return found;
  }
  for (const std::string& variable : search.variables)
    if (const char* folder = std::getenv(variable.c_str())) add_libraries_of(folder, search, found);
  found.insert(found.end(), search.names.begin(), search.names.end());
  return found;
}

}  // namespace

Result<SharedLibrary> SharedLibrary::open(const LibrarySearch& search, const fs::path& given) {
  std::string why = fmt::format("no {} there", fmt::join(search.names, " and no "));
  bool needs_another = false;
  for (const fs::path& path : candidates(search, given)) {
    if (void* const handle = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE))
      return SharedLibrary(handle, path.string());
    const std::string told = dlerror();
    // Keeps the message about a library that exists and lacks a dependency: it explains more than "not found".
    if (needs_another) continue;
    needs_another = !told.starts_with(path.string());
    why = told;
  }
  return Status::error(fmt::format("{} is not found ({}); accepted: {}", search.whose, why, search.accepted));
}

SharedLibrary::SharedLibrary(SharedLibrary&& other) noexcept
    : handle_(std::exchange(other.handle_, nullptr)), path_(std::move(other.path_)), missing_(other.missing_) {}

SharedLibrary::~SharedLibrary() {
  if (handle_ != nullptr) dlclose(handle_);
}

void* SharedLibrary::symbol(const char* name) const noexcept { return dlsym(handle_, name); }

}  // namespace tactus::hal
