// A raw CAN socket that never waits, with the kernel's receive stamps: what both ends of a link stand on.
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
  can_err_mask_t errors{0};  // which error frames come
  bool fd{false};            // CAN FD frames as well; the interface must have that MTU
  unsigned queued_sends{6};  // about so many frames may wait for the bus, at least 6: one that waited is old
};

// Where opening stopped, and the error number there.
struct CanOpenError {
  enum class Step : std::uint8_t { kNone, kSocket, kName, kOption, kFd, kBind };
  Step step{Step::kNone};
  int number{0};
};

struct CanReceived {
  std::uint32_t id{0};  // 11 bits; of an error frame: its class bits
  bool error{false}, fd{false};
  std::int64_t arrival_ns{0};  // CLOCK_MONOTONIC, stamped by the kernel as the driver handed the frame on
  std::span<const std::byte> data;
};

// Only standard data frames with this identifier.
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

  // How many came, 0 to kBatch; frame(i) until the next call. `error`: the error number if nothing could be read at
  // all (ENETDOWN), 0 if there is merely nothing.
  unsigned receive(int& error) noexcept;
  const CanReceived& frame(unsigned i) const noexcept { return received_[i]; }

  // Waits until something can be read; false if nothing came within the bound.
  bool wait(std::chrono::nanoseconds bound) noexcept;

  // 0, or the error number: ENOBUFS and EAGAIN when the bus does not take frames, ENETDOWN. More than 8 bytes go as
  // CAN FD with the bit rate switched; their number is one that CAN FD has.
  int send(std::uint32_t id, std::span<const std::byte> data) noexcept;

  std::uint32_t lost() const noexcept { return lost_; }  // frames that the kernel dropped for want of room; wraps
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
