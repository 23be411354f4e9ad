// The device's end of a CAN link on a Linux board: firmware::DeviceLink over SocketCAN, classic or FD.
//
// Thread: open() [setup]; the rest [rt], the control period's: no wait, no allocation. Bound: receive_command() reads
// at most CanSocket::kQueuedFrames per period; up to kWaitingRequests service requests wait, more are dropped and
// counted. On failures: while the controller is bus-off nothing is sent (state frames are counted as failed; the
// device's watchdog counts the missing commands). Sending resumes when the kernel reports the restart (automatic with
// `ip link set can0 type can restart-ms 100`) or when any frame arrives.
#pragma once

#include "firmware/board.h"
#include "firmware/boards/linux_can/can_error_frame.h"
#include "firmware/boards/linux_can/can_socket.h"
#include "firmware/can_codec.h"

namespace tactus::firmware {

struct CanDeviceOptions {
  const char* interface { "can0" };
  std::uint8_t node{1};  // 1 to kMaxCanNode
  bool fd{false};
};

struct CanDeviceCounters {
  std::uint64_t commands{0};     // complete commands
  std::uint64_t superseded{0};   // complete commands beyond the first of a period
  std::uint64_t incomplete{0};   // commands with a missing fragment
  std::uint64_t malformed{0};    // frames on the device's identifiers without valid content
  std::uint64_t lost{0};         // lost to a full queue: of the kernel, the controller (once each time), of requests
  std::uint64_t states{0};       // sent states
  std::uint64_t send_failed{0};  // states not sent, or only in part
  std::uint64_t bus_off{0}, error_passive{0}, arbitration_lost{0}, interface_down{0};
};

class CanDeviceLink {
 public:
  static constexpr std::size_t kWaitingRequests = 4;

  [[nodiscard]] CanOpenError open(const CanDeviceOptions& options) noexcept;

  std::size_t receive_command(std::span<std::byte, kMaxFrameSize> buffer) noexcept;
  void send_state(std::span<const std::byte> frame) noexcept;
  bool receive_service(ServiceMessage& message) noexcept;
  void reply_service(const ServiceMessage& message) noexcept;

  bool bus_off() const noexcept { return bus_off_; }
  CanDeviceCounters counters() const noexcept;
  BusErrors bus_errors() const noexcept { return bus_errors_; }

 private:
  bool read_batch() noexcept;
  // If the frame completes a command, copies it into `command` and returns its size; else 0.
  std::size_t take(const CanReceived& frame, std::span<std::byte, kMaxFrameSize> command) noexcept;
  std::size_t take_command(const CanReceived& frame, std::span<std::byte, kMaxFrameSize> command) noexcept;
  void take_request(const CanReceived& frame) noexcept;
  void take_error(const CanReceived& frame) noexcept;
  bool send_fragments(const StateFrame& frame) noexcept;

  CanDeviceOptions options_;
  CanSocket socket_;
  StateSplitter splitter_;
  CommandAssembler assembler_;
  unsigned batches_{0}, batch_size_{0}, next_in_batch_{0};  // in this period
  bool command_seen_{false}, lost_{false};                  // in this period
  std::array<ServiceMessage, kWaitingRequests> requests_{};
  std::size_t first_request_{0}, waiting_requests_{0};
  bool bus_off_{false};
  CanDeviceCounters counters_{};
  BusErrors bus_errors_;
};

static_assert(DeviceLink<CanDeviceLink> && TellsBusErrors<CanDeviceLink>);

}  // namespace tactus::firmware
