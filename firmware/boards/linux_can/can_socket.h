// A non-blocking raw CAN socket with the kernel's receive time stamps; used by both ends of a link.
//
// Thread: open() [setup]; the rest [rt], one owner. Bound: receive() takes at most kBatch frames, send() one; each is
// one system call that returns at once. wait() returns after `bound` at the latest. Beyond the bound: the kernel keeps
// at most about kQueuedFrames unread frames and drops the newest; lost() counts them.
#pragma once

#include <linux/can.h>
#include <linux/can/error.h>
#include <sys/socket.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>

namespace tactus::firmware {

struct CanSocketOptions {
  const char* interface { nullptr };
  std::span<const can_filter> filters;
  can_err_mask_t errors{0};  // error frames to receive
  bool fd{false};            // CAN FD frames as well; the interface must have that MTU
  unsigned queued_sends{6};  // approximate send queue, at least 6; kept short because a frame that waited is old
};

// The step at which opening failed, and its error number.
struct CanOpenError {
  enum class Step : std::uint8_t { kNone, kSocket, kName, kOption, kFd, kBind };
  Step step{Step::kNone};
  int number{0};
};

struct CanReceived {
  std::uint32_t id{0};  // 11 bits, or 29 and CAN_EFF_FLAG; of an error frame: its class bits
  bool error{false}, fd{false};
  std::int64_t arrival_ns{0};  // CLOCK_MONOTONIC, from the kernel's stamp when the driver delivered the frame
  std::span<const std::byte> data;
};

// Filter for standard data frames with this identifier.
constexpr can_filter exactly(std::uint32_t id) noexcept { return {id, CAN_SFF_MASK | CAN_EFF_FLAG | CAN_RTR_FLAG}; }

class CanSocket {
 public:
  static constexpr unsigned kBatch = 32, kQueuedFrames = 128;

  CanSocket() = default;
  ~CanSocket();
  CanSocket(const CanSocket&) = delete;
  CanSocket& operator=(const CanSocket&) = delete;

  [[nodiscard]] CanOpenError open(const CanSocketOptions& options) noexcept;
  void close() noexcept;

  // Returns the number of received frames, 0 to kBatch; frame(i) is valid until the next call. `error`: the error
  // number if reading failed (ENETDOWN), 0 if there was no frame.
  unsigned receive(int& error) noexcept;
  const CanReceived& frame(unsigned i) const noexcept { return received_[i]; }

  // Waits until a frame can be read; false if none arrived within the bound.
  bool wait(std::chrono::nanoseconds bound) noexcept;

  // Returns 0, or the error number: ENOBUFS and EAGAIN when the send queue is full, ENETDOWN. `id`: 11 bits, or 29 and
  // CAN_EFF_FLAG. More than 8 bytes are sent as CAN FD with the bit rate switched; their number must be a valid CAN FD
  // length. Fewer are sent so if `fd` says so.
  int send(std::uint32_t id, std::span<const std::byte> data, bool fd = false) noexcept;

  std::uint32_t lost() const noexcept { return lost_; }  // frames that the kernel dropped on a full queue; wraps
  int descriptor() const noexcept { return socket_; }

 private:
  void prepare_batch() noexcept;
  void note_control(msghdr& header, CanReceived& received, std::int64_t monotonic_from_real_ns) noexcept;

  int socket_{-1};
  std::uint32_t lost_{0};
  std::array<canfd_frame, kBatch> frames_{};
  std::array<CanReceived, kBatch> received_{};
  std::array<iovec, kBatch> parts_{};
  std::array<mmsghdr, kBatch> headers_{};
  alignas(cmsghdr) std::array<std::array<char, 64>, kBatch> control_{};
};

}  // namespace tactus::firmware
