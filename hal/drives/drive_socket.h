// A CAN bus with drives on SocketCAN: a DriveBus for one interface.
//
// Thread: open(), wait() [setup]; the rest [rt], one owner; every call returns at once. Bound: receive() makes one
// system call for up to 32 frames. A full send queue refuses the frame; nothing is repeated. Identifiers of others are
// filtered by the kernel; own frames do not come back.
#pragma once

#include "firmware/boards/linux_can/can_socket.h"
#include "hal/drives/drive_axis.h"
#include "hal/drives/drive_bus.h"
#include "rt/base/result.h"

namespace tactus::hal {

class DriveSocket final : public DriveBus {
 public:
  // The bus of `drives` with this number, on this interface. Errors, one line: no such interface, down, another bit
  // rate than described, a serial-line adapter, no permission.
  static Result<std::unique_ptr<DriveBus>> open(const DriveDescription& drives, unsigned bus,
                                                const std::string& interface);

  bool receive(ReceivedDriveFrame& received) noexcept override;
  bool send(const DriveFrame& frame) noexcept override;
  bool connected() const noexcept override { return connected_; }
  std::int64_t now_ns() const noexcept override;
  void wait(std::chrono::nanoseconds longest) override { (void)socket_.wait(longest); }

 private:
  bool take(const firmware::CanReceived& from, ReceivedDriveFrame& received) noexcept;

  firmware::CanSocket socket_;
  unsigned count_{0}, next_{0};  // of the frames that the last system call brought
  bool connected_{true};
};

// One per described bus. `interfaces`: as many, in order.
Result<DriveBuses> open_drive_sockets(const DriveDescription& drives, const std::vector<std::string>& interfaces);

}  // namespace tactus::hal
