// The host's end of a CAN link: FrameLink over SocketCAN, classic or FD (firmware/can_codec.h).
//
// Thread: open(), start(), call() [setup] and normal threads; the rest [rt], by the haptic thread alone. call() uses a
// socket of its own. A thread of normal priority rebinds the socket when the interface disappears and returns (an
// adapter that is unplugged); the haptic thread picks the new socket up with one atomic read.
// Bound: receive() reads at most kMaxFrames frames, then waits at most Options::wait for the rest of an incomplete
// state, in at most kMaxWakes pieces, and reads at most kMaxFrames frames after each; a babbling node costs at most
// those frames (the kernel filters identifiers of other nodes). send() is one or two system calls that return at once.
// Beyond the bounds and on failures: frames that the kernel drops because its queue is full are counted; it drops the
// newest, and the next receive() sees what comes after. Interface down, gone, or bus-off: disconnected, counted, and
// connected again with the next state frame. If the bus accepts no frames, a few commands are queued, then send()
// refuses and counts.
#pragma once

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "firmware/boards/linux_can/can_socket.h"
#include "firmware/can_codec.h"
#include "hal/can/can_interface.h"
#include "hal/frame_link.h"

namespace tactus::hal {

enum class CanFormat : std::uint8_t { kAuto, kClassic, kFd };  // auto: the format in which the device sends

struct CanOptions {
  std::string interface { "can0" };
  std::uint8_t node{1};  // the device's, 1 to firmware::kMaxCanNode
  CanFormat format{CanFormat::kAuto};
  std::chrono::nanoseconds period{1'000'000};
  std::chrono::nanoseconds wait{50'000};       // receive()'s wait if no state is there; at most the period; 0: none
  std::chrono::milliseconds first_frame{500};  // open()'s wait for the device's first frame
};

// Errors on the bus, since start().
struct CanBusErrors {
  std::uint64_t bus_off{0}, restarted{0}, error_warning{0}, error_passive{0};
  std::uint64_t arbitration_lost{0};        // normal on a busy bus, where the controller reports it
  std::uint64_t protocol{0};                // bit, stuff, form or CRC errors, missing acknowledgement
  std::uint64_t controller_full{0};         // frames lost in the controller
  std::uint64_t queue_full{0};              // frames lost because the kernel's queue was full
  std::uint64_t incomplete{0};              // classic: states with a missing fragment
  std::uint8_t tx_errors{0}, rx_errors{0};  // the controller's counters, where it reports them
};

class CanLink {
 public:
  static constexpr unsigned kMaxFrames = firmware::CanSocket::kQueuedFrames, kMaxWakes = 4;

  // Errors, one line each: those of check_can_interface, and no frame received from this node id.
  static Result<std::unique_ptr<CanLink>> open(const CanOptions& options);
  // Drops waiting frames and clears the counters, just before the first tick.
  Status start();

  ReceivedFrame receive(std::span<std::byte, firmware::kMaxFrameSize> buffer) noexcept;
  bool send(std::span<const std::byte> frame) noexcept;
  bool connected() const noexcept { return connected_; }
  LinkCounters counters() const noexcept;
  Result<firmware::ServiceMessage> call(const firmware::ServiceMessage& request, std::chrono::milliseconds timeout);

  CanBusErrors bus_errors() const noexcept;
  bool is_fd() const noexcept { return fd_; }
  const CanInterface& interface() const noexcept { return interface_; }  // as it was at open()

 private:
  enum class SocketState : std::uint8_t { kGood, kLost, kReplaced };

  CanLink(const CanOptions& options, const CanInterface& interface, bool fd);
  firmware::CanOpenError open_socket(firmware::CanSocket& socket) const noexcept;
  firmware::CanSocket& socket() noexcept { return sockets_[active_]; }

  void drain(std::span<std::byte, firmware::kMaxFrameSize> buffer, ReceivedFrame& newest) noexcept;
  bool take(const firmware::CanReceived& frame, std::span<std::byte, firmware::kMaxFrameSize> buffer) noexcept;
  void take_error(const firmware::CanReceived& frame) noexcept;
  void note_failure(int error) noexcept;
  void disconnect() noexcept;
  void take_over_socket() noexcept;
  int send_classic(const firmware::CommandFrame& command) noexcept;
  void keep_bound(const std::stop_token& stop);

  CanOptions options_;
  CanInterface interface_;
  bool fd_;
  std::array<firmware::CanSocket, 2>
      sockets_;  // sockets_[active_]: the haptic thread's; the other: the keeper thread's
  unsigned active_{0};
  std::atomic<SocketState> socket_state_{SocketState::kGood};
  firmware::StateAssembler assembler_;
  std::uint32_t incomplete_before_{0}, malformed_before_{0};  // the assembler's counts at start()
  bool connected_{true};
  LinkCounters counters_;
  CanBusErrors errors_;
  std::mutex keeper_mutex_;
  std::condition_variable_any keeper_wake_;
  std::jthread keeper_;  // declared last: it uses the other members
};

static_assert(FrameLink<CanLink>);

}  // namespace tactus::hal
