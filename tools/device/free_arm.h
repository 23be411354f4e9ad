// An arm of drives without force: the drives are disabled and report their angles while a person moves the arm.
//
// Thread: normal. read() takes kReadings polls of all drives, 5 ms apart; bound: kPatience for each.
#pragma once

#include <chrono>

#include "hal/drives/drive_bus.h"
#include "hal/profiles.h"
#include "rt/base/result.h"

namespace tactus::device {

class FreeArm {
 public:
  static constexpr unsigned kReadings = 20;
  static constexpr std::chrono::milliseconds kPatience{50}, kPause{5};
  static constexpr unsigned kMostWaiting = 1024;  // frames that a bus may hold
  static constexpr double kStill_rad = 0.02;      // of the axes: the angles of one reading lie closer together

  FreeArm(const hal::DriveDescription& drives, const hal::DriveBuses& buses) : drives_(drives), buses_(buses) {}

  // One angle of each drive. Error: which drive does not answer, or is enabled.
  Result<hal::AxisVector> poll();
  // Mean of kReadings. Error: also that the tool moved.
  Result<hal::AxisVector> read();

 private:
  void discard_old();

  const hal::DriveDescription& drives_;
  const hal::DriveBuses& buses_;
};

}  // namespace tactus::device
