#include "hal/sdk/dhd_library.h"

#include <fmt/format.h>

namespace tactus::hal {
namespace {

constexpr int kMajor = 3, kLeastMinor = 16;

}  // namespace

Result<std::unique_ptr<DhdLibrary>> DhdLibrary::load(const std::filesystem::path& folder) {
  static const LibrarySearch kSearch{.whose = "Force Dimension's library",
                                     .names = {"libdrd.so.3", "libdhd.so.3"},  // libdrd has all of libdhd
                                     .below = {"lib/release/lin-x86_64-gcc"},
                                     .variables = {"FDSDK", "FORCEDIM_SDK"},
                                     .accepted = "dhd:FOLDER with the maker's SDK, or $FDSDK"};
  auto opened = SharedLibrary::open(kSearch, folder);
  if (!opened.ok()) return opened.status();
  std::unique_ptr<DhdLibrary> library(new DhdLibrary(std::move(opened).value()));
  if (Status status = library->resolve(); !status.ok()) return status;
  return library;
}

Status DhdLibrary::resolve() {
#define TACTUS_DHD(name) library_.find(functions_.name, #name)
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
  library_.find(functions_.dhdSetWatchdog, "dhdSetWatchdog", true);
  library_.find(functions_.drdIsInitialized, "drdIsInitialized", true);
  library_.find(functions_.dhdOpenSerial, "dhdOpenSerial", true);
  if (library_.missing() == nullptr) return check_version();
  return Status::error(
      fmt::format("Force Dimension's library has no function {}; accepted: its SDK 3.16 or newer", library_.missing()));
}

Status DhdLibrary::check_version() {
  int version[4]{};
  functions_.dhdGetSDKVersion(&version[0], &version[1], &version[2], &version[3]);
  version_ = fmt::format("{}.{}.{}", version[0], version[1], version[2]);
  if (version[0] == kMajor && version[1] >= kLeastMinor) return Status::good();
  return Status::error(fmt::format(
      "Force Dimension's library {} is SDK {}, whose functions are not known here to be the same; accepted: {}.{} and "
      "newer of {}",
      path(), version_, kMajor, kLeastMinor, kMajor));
}

}  // namespace tactus::hal
