#include "hal/sdk/hd_library.h"

#include <fmt/format.h>

namespace tactus::hal {

Result<std::unique_ptr<HdLibrary>> HdLibrary::load(const std::filesystem::path& folder) {
  static const LibrarySearch kSearch{.whose = "3D Systems' library HD",
                                     .names = {"libHD.so"},
                                     .below = {"lib", "lib64", "usr/lib", "usr/lib64"},
                                     .variables = {"OH_SDK_BASE"},
                                     .accepted = "openhaptics:FOLDER with the maker's OpenHaptics, or $OH_SDK_BASE"};
  auto opened = SharedLibrary::open(kSearch, folder);
  if (!opened.ok()) return opened.status();
  std::unique_ptr<HdLibrary> library(new HdLibrary(std::move(opened).value()));
  if (Status status = library->resolve(); !status.ok()) return status;
  return library;
}

Status HdLibrary::resolve() {
#define TACTUS_HD(name) library_.find(functions_.name, #name)
  TACTUS_HD(hdInitDevice);
  TACTUS_HD(hdDisableDevice);
  TACTUS_HD(hdMakeCurrentDevice);
  TACTUS_HD(hdBeginFrame);
  TACTUS_HD(hdEndFrame);
  TACTUS_HD(hdGetError);
  TACTUS_HD(hdGetErrorString);
  TACTUS_HD(hdEnable);
  TACTUS_HD(hdDisable);
  TACTUS_HD(hdIsEnabled);
  TACTUS_HD(hdGetDoublev);
  TACTUS_HD(hdGetIntegerv);
  TACTUS_HD(hdSetDoublev);
  TACTUS_HD(hdGetString);
  TACTUS_HD(hdCheckCalibration);
  TACTUS_HD(hdUpdateCalibration);
  TACTUS_HD(hdStartScheduler);
  TACTUS_HD(hdStopScheduler);
  TACTUS_HD(hdSetSchedulerRate);
  TACTUS_HD(hdScheduleAsynchronous);
  TACTUS_HD(hdUnschedule);
#undef TACTUS_HD
  library_.find(functions_.hdGetSchedulerTimeStamp, "hdGetSchedulerTimeStamp", true);
  if (library_.missing() == nullptr) return Status::good();
  return Status::error(
      fmt::format("3D Systems' library HD has no function {}; accepted: OpenHaptics 3.0 to 3.5", library_.missing()));
}

}  // namespace tactus::hal
