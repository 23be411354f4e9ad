#include "tools/device/free_arm.h"

#include <fmt/format.h>

#include <algorithm>

#include "hal/drives/drive_codec.h"

namespace tactus::device {

using hal::AxisVector;

// Drops waiting frames: drives that send unasked reported an earlier position of the arm in them.
void FreeArm::discard_old() {
  hal::ReceivedDriveFrame old;
  for (const auto& bus : buses_)
    for (unsigned i = 0; i < kMostWaiting && bus->receive(old); ++i) continue;
}

Result<AxisVector> FreeArm::poll() {
  discard_old();
  const hal::DriveCodec& codec = hal::codec_of(drives_.family);
  AxisVector angles{};
  for (unsigned i = 0; i < drives_.axes.size(); ++i) {
    const hal::DriveAxis& axis = drives_.axes[i];
    hal::DriveBus& bus = *buses_[axis.bus];
    const hal::DriveFrame request = codec.encode(axis, {.action = hal::DriveAction::kPoll});
    if (request.size > 0) (void)bus.send(request);
    const std::int64_t deadline_ns = bus.now_ns() + std::chrono::nanoseconds(kPatience).count();
    hal::DriveAnswer answer;
    while (!answer.has_position) {
      const std::int64_t left_ns = deadline_ns - bus.now_ns();
      if (left_ns <= 0) return Status::error(fmt::format("axis {} (drive {}) does not answer", i, axis.id));
      hal::ReceivedDriveFrame received;
      if (bus.receive(received))
        (void)codec.decode(axis, received.frame, answer);
      else
        bus.wait(std::chrono::nanoseconds(left_ns));
    }
    if (answer.has_mode && answer.mode == hal::DriveMode::kEnabled)
      return Status::error(fmt::format("axis {} (drive {}) is enabled; end the program that drives it", i, axis.id));
    angles[i] = answer.position_rad;
  }
  return angles;
}

Result<AxisVector> FreeArm::read() {
  AxisVector sum{}, low{}, high{};
  for (unsigned k = 0; k < kReadings; ++k) {
    const auto angles = poll();
    if (!angles.ok()) return angles.status();
    for (unsigned i = 0; i < drives_.axes.size(); ++i) {
      const double angle = angles.value()[i];
      sum[i] += angle;
      low[i] = k == 0 ? angle : std::min(low[i], angle);
      high[i] = k == 0 ? angle : std::max(high[i], angle);
    }
    buses_[0]->wait(kPause);
  }
  for (unsigned i = 0; i < drives_.axes.size(); ++i) {
    if (high[i] - low[i] > kStill_rad * drives_.axes[i].ratio)
      return Status::error(fmt::format("axis {} moved by {:.3f} rad; hold the tool still", i, high[i] - low[i]));
    sum[i] /= kReadings;
  }
  return sum;
}

}  // namespace tactus::device
