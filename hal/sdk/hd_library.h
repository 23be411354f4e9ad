// 3D Systems' library HD (libHD, of OpenHaptics), loaded on request: the functions that tactus calls, by
// name.
//
// The library is the user's own, under a licence that the user holds: nothing of it is part of tactus, and the
// declarations here are those of its documented interface. Thread: load() [setup]. The functions that concern a
// device's state belong into a call of the library's scheduler; the others are for set-up.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>

#include "hal/sdk/shared_library.h"

namespace tactus::hal {

struct HdError {
  std::uint32_t code;
  std::int32_t internal_code;
  std::uint32_t handle;
};

struct HdFunctions {
  std::uint32_t (*hdInitDevice)(const char* name);  // null: the default device
  void (*hdDisableDevice)(std::uint32_t handle);
  void (*hdMakeCurrentDevice)(std::uint32_t handle);
  void (*hdBeginFrame)(std::uint32_t handle);
  void (*hdEndFrame)(std::uint32_t handle);
  HdError (*hdGetError)();  // the newest that was not taken yet; code 0: none
  const char* (*hdGetErrorString)(std::uint32_t code);
  void (*hdEnable)(std::uint32_t capability);
  void (*hdDisable)(std::uint32_t capability);
  unsigned char (*hdIsEnabled)(std::uint32_t capability);
  void (*hdGetDoublev)(std::uint32_t parameter, double* values);
  void (*hdGetIntegerv)(std::uint32_t parameter, int* values);
  void (*hdSetDoublev)(std::uint32_t parameter, const double* values);
  const char* (*hdGetString)(std::uint32_t parameter);
  std::uint32_t (*hdCheckCalibration)();
  void (*hdUpdateCalibration)(std::uint32_t style);
  void (*hdStartScheduler)();
  void (*hdStopScheduler)();
  void (*hdSetSchedulerRate)(unsigned long rate_Hz);
  unsigned long (*hdScheduleAsynchronous)(unsigned (*callback)(void*), void* context, unsigned short priority);
  void (*hdUnschedule)(unsigned long scheduled);
  double (*hdGetSchedulerTimeStamp)();  // s since the scheduler's call began; null: a library without it
};

class HdLibrary {
 public:
  // `folder`: where libHD is, or libHD itself; empty: $OH_SDK_BASE, then where the system looks. Error, one line: where
  // it looked, what libHD lacks, or which function it has not.
  static Result<std::unique_ptr<HdLibrary>> load(const std::filesystem::path& folder);

  const HdFunctions& functions() const noexcept { return functions_; }
  const std::string& path() const noexcept { return library_.path(); }

 private:
  explicit HdLibrary(SharedLibrary library) : library_(std::move(library)) {}
  Status resolve();

  SharedLibrary library_;
  HdFunctions functions_{};
};

}  // namespace tactus::hal
