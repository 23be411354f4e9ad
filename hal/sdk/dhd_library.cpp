#include "hal/sdk/dhd_library.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <vector>

namespace tactus::hal {
namespace {

namespace fs = std::filesystem;

// Inside an unpacked archive of the maker.
constexpr const char* kInArchive = "lib/release/lin-x86_64-gcc";

bool is_library(const fs::path& path) {
  const std::string name = path.filename().string();
  return name.starts_with("libdrd.so.3") || name.starts_with("libdhd.so.3");
}

// The libraries in a folder, libdrd first: it has all of libdhd.
void add_libraries_of(const fs::path& folder, std::vector<fs::path>& found) {
  std::vector<fs::path> here;
  std::error_code error;
  for (const fs::path& place : {folder, folder / kInArchive})
    for (const auto& entry : fs::directory_iterator(place, error))
      if (is_library(entry.path())) here.push_back(entry.path());
  std::sort(here.begin(), here.end(),
            [](const fs::path& a, const fs::path& b) { return a.filename().string() > b.filename().string(); });
  found.insert(found.end(), here.begin(), here.end());
}

std::vector<fs::path> candidates(const fs::path& given) {
  std::vector<fs::path> found;
  std::error_code error;
  if (!given.empty()) {
    if (fs::is_directory(given, error))
      add_libraries_of(given, found);
    else
      found.push_back(given);
    return found;
  }
  for (const char* variable : {"FDSDK", "FORCEDIM_SDK"})
    if (const char* folder = std::getenv(variable)) add_libraries_of(folder, found);
  found.emplace_back("libdrd.so.3");
  found.emplace_back("libdhd.so.3");
  return found;
}

}  // namespace

Result<std::unique_ptr<DhdLibrary>> DhdLibrary::load(const fs::path& folder) {
  std::unique_ptr<DhdLibrary> library(new DhdLibrary());
  std::string why = "no libdrd.so.3 and no libdhd.so.3 there";
  for (const fs::path& path : candidates(folder)) {
    library->handle_ = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (library->handle_ != nullptr) break;
    why = dlerror();
  }
  if (library->handle_ == nullptr)
    return Status::error(fmt::format(
        "Force Dimension's library is not found ({}); accepted: dhd:FOLDER with the maker's SDK, or $FDSDK", why));
  if (Status status = library->resolve(); !status.ok()) return status;
  return library;
}

DhdLibrary::~DhdLibrary() {
  if (handle_ != nullptr) dlclose(handle_);
}

Status DhdLibrary::resolve() {
  const char* missing = nullptr;
  const auto find = [&](auto& function, const char* name, bool optional) {
    void* const symbol = dlsym(handle_, name);
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(symbol);
    if (symbol == nullptr && !optional && missing == nullptr) missing = name;
  };
#define TACTUS_DHD(name) find(functions_.name, #name, false)
  TACTUS_DHD(dhdOpenID);
  TACTUS_DHD(dhdClose);
  TACTUS_DHD(dhdGetDeviceCount);
  TACTUS_DHD(dhdErrorGetLastStr);
  TACTUS_DHD(dhdGetSDKVersion);
  TACTUS_DHD(dhdGetSystemName);
  TACTUS_DHD(dhdGetSystemType);
  TACTUS_DHD(dhdGetSerialNumber);
  TACTUS_DHD(dhdHasWrist);
  TACTUS_DHD(dhdHasActiveWrist);
  TACTUS_DHD(dhdGetPositionAndOrientationFrame);
  TACTUS_DHD(dhdSetForceAndTorqueAndGripperForce);
  TACTUS_DHD(dhdGetButtonMask);
  TACTUS_DHD(dhdEnableForce);
  TACTUS_DHD(dhdSetBrakes);
  TACTUS_DHD(dhdStop);
  TACTUS_DHD(dhdGetStatus);
  TACTUS_DHD(dhdEnableExpertMode);
  TACTUS_DHD(dhdSetTimeGuard);
#undef TACTUS_DHD
  find(functions_.dhdSetWatchdog, "dhdSetWatchdog", true);
  find(functions_.drdIsInitialized, "drdIsInitialized", true);
  if (missing == nullptr) return Status::good();
  return Status::error(
      fmt::format("Force Dimension's library has no function {}; accepted: its SDK 3.16 or newer", missing));
}

}  // namespace tactus::hal
