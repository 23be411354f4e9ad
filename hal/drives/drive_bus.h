// A CAN bus with drives on it, as an arm of drives sees it: SocketCAN (drive_socket.h) or drives in this process
// (simulated_drives.h).
//
// Thread: receive(), send(), connected(), now_ns() [rt], by one thread: no wait, no allocation, no lock; wait()
// [setup].
#pragma once

#include <chrono>
#include <memory>
#include <vector>

#include "hal/drives/drive_frame.h"

namespace tactus::hal {

struct ReceivedDriveFrame {
  DriveFrame frame;
  std::int64_t arrival_ns{0};  // on the clock of now_ns()
};

class DriveBus {
 public:
  virtual ~DriveBus() = default;
  virtual bool receive(ReceivedDriveFrame& received) noexcept = 0;  // false: no frame waits
  virtual bool send(const DriveFrame& frame) noexcept = 0;          // false: the bus did not take it
  virtual bool connected() const noexcept = 0;                      // false: down, gone or bus-off
  virtual std::int64_t now_ns() const noexcept = 0;
  // Returns when a frame waits or the time is over.
  virtual void wait(std::chrono::nanoseconds longest) = 0;
};

using DriveBuses = std::vector<std::unique_ptr<DriveBus>>;

}  // namespace tactus::hal
