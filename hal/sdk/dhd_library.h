// Force Dimension's library (libdrd, libdhd), loaded on request: the functions that tactus calls, by name.
//
// The library is the user's own: nothing of it is part of tactus, and the declarations here are those of its documented
// interface. Thread: load() [setup]. The functions may be called by any thread; they wait for the bus.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <utility>

#include "hal/sdk/shared_library.h"

namespace tactus::hal {

struct DhdFunctions {
  int (*dhdOpenID)(char index);
  int (*dhdOpenSerial)(int serial);  // null: a library without it
  int (*dhdClose)(char id);
  int (*dhdGetDeviceCount)();
  const char* (*dhdErrorGetLastStr)();
  void (*dhdGetSDKVersion)(int* major, int* minor, int* release, int* revision);
  const char* (*dhdGetSystemName)(char id);
  int (*dhdGetSystemType)(char id);
  int (*dhdGetSerialNumber)(unsigned short* serial, char id);
  bool (*dhdHasWrist)(char id);
  bool (*dhdHasActiveWrist)(char id);
  int (*dhdGetPositionAndOrientationFrame)(double* x, double* y, double* z, double matrix[3][3], char id);
  int (*dhdSetForceAndTorqueAndGripperForce)(double fx, double fy, double fz, double tx, double ty, double tz,
                                             double gripper, char id);
  unsigned (*dhdGetButtonMask)(char id);
  int (*dhdEnableForce)(unsigned char on, char id);
  int (*dhdSetBrakes)(int on, char id);
  int (*dhdStop)(char id);
  int (*dhdGetStatus)(int status[17], char id);
  int (*dhdEnableExpertMode)();
  int (*dhdSetTimeGuard)(int min_period_us, char id);
  int (*dhdSetWatchdog)(unsigned char steps, char id);  // of 125 us; null: a library without it
  bool (*drdIsInitialized)(char id);                    // null: libdhd alone
};

class DhdLibrary {
 public:
  // `folder`: where the libraries are, or one of them; empty: $FDSDK, $FORCEDIM_SDK, then where the system looks.
  // Error, one line: where it looked, which function the library lacks, or its version.
  static Result<std::unique_ptr<DhdLibrary>> load(const std::filesystem::path& folder);

  const DhdFunctions& functions() const noexcept { return functions_; }
  // "3.17.5".
  const std::string& version() const noexcept { return version_; }
  const std::string& path() const noexcept { return library_.path(); }

 private:
  explicit DhdLibrary(SharedLibrary library) : library_(std::move(library)) {}
  Status resolve();
  Status check_version();

  SharedLibrary library_;
  DhdFunctions functions_{};
  std::string version_;
};

}  // namespace tactus::hal
