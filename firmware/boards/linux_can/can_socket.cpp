#include "firmware/boards/linux_can/can_socket.h"

#include <linux/can/raw.h>
#include <net/if.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace tactus::firmware {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
// Bytes that the kernel accounts for one queued frame (Linux 6.1, 64-bit). Queue sizes are set in bytes, and the kernel
// doubles the number. If it accounts more, fewer frames fit.
constexpr int kKernelBytesPerFrame = 768;

std::int64_t now_ns(clockid_t clock) noexcept {
  timespec time{};
  clock_gettime(clock, &time);
  return time.tv_sec * kSecond_ns + time.tv_nsec;
}

template <class T>
bool set_option(int socket, int level, int name, const T& value) noexcept {
  return setsockopt(socket, level, name, &value, sizeof value) == 0;
}

bool set_options(int socket, const CanSocketOptions& options) noexcept {
  const int on = 1, queue = CanSocket::kQueuedFrames * kKernelBytesPerFrame / 2;
  const int sends = static_cast<int>(options.queued_sends) * kKernelBytesPerFrame / 2;
  const auto size = static_cast<socklen_t>(options.filters.size_bytes());
  return setsockopt(socket, SOL_CAN_RAW, CAN_RAW_FILTER, options.filters.data(), size) == 0 &&
         set_option(socket, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, options.errors) &&
         set_option(socket, SOL_SOCKET, SO_TIMESTAMPNS, on) && set_option(socket, SOL_SOCKET, SO_RXQ_OVFL, on) &&
         set_option(socket, SOL_SOCKET, SO_RCVBUF, queue) && set_option(socket, SOL_SOCKET, SO_SNDBUF, sends);
}

}  // namespace

CanSocket::~CanSocket() { close(); }

void CanSocket::close() noexcept {
  if (socket_ >= 0) ::close(socket_);
  socket_ = -1;
}

CanOpenError CanSocket::open(const CanSocketOptions& options) noexcept {
  using Step = CanOpenError::Step;
  close();
  lost_ = 0;
  const auto failed = [this](Step step) {
    const CanOpenError error{step, errno};
    close();
    return error;
  };
  socket_ = socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW);
  if (socket_ < 0) return failed(Step::kSocket);
  const unsigned index = if_nametoindex(options.interface);
  if (index == 0) return failed(Step::kName);
  if (!set_options(socket_, options)) return failed(Step::kOption);
  if (const int on = 1; options.fd && !set_option(socket_, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, on))
    return failed(Step::kFd);
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = static_cast<int>(index);
  if (bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) return failed(Step::kBind);
  prepare_batch();
  return {};
}

void CanSocket::prepare_batch() noexcept {
  for (unsigned i = 0; i < kBatch; ++i) {
    parts_[i] = {&frames_[i], sizeof frames_[i]};
    headers_[i] = {};
    headers_[i].msg_hdr.msg_iov = &parts_[i];
    headers_[i].msg_hdr.msg_iovlen = 1;
    headers_[i].msg_hdr.msg_control = control_[i].data();
  }
}

unsigned CanSocket::receive(int& error) noexcept {
  error = 0;
  for (mmsghdr& header : headers_) header.msg_hdr.msg_controllen = control_[0].size();
  const int count = recvmmsg(socket_, headers_.data(), kBatch, MSG_DONTWAIT, nullptr);
  if (count < 0) {
    if (errno != EAGAIN && errno != EINTR) error = errno;
    return 0;
  }
  const std::int64_t monotonic_from_real_ns = now_ns(CLOCK_MONOTONIC) - now_ns(CLOCK_REALTIME);
  for (unsigned i = 0; i < static_cast<unsigned>(count); ++i) {
    const canfd_frame& frame = frames_[i];
    CanReceived& received = received_[i];
    received.error = (frame.can_id & CAN_ERR_FLAG) != 0;
    const bool extended = (frame.can_id & CAN_EFF_FLAG) != 0;
    received.id = frame.can_id & (received.error ? CAN_ERR_MASK
                                  : extended     ? CAN_EFF_FLAG | CAN_EFF_MASK
                                                 : CAN_SFF_MASK);
    received.fd = headers_[i].msg_len == CANFD_MTU;
    const std::size_t capacity = received.fd ? CANFD_MAX_DLEN : CAN_MAX_DLEN;
    received.data = std::as_bytes(std::span(frame.data)).first(frame.len <= capacity ? frame.len : capacity);
    note_control(headers_[i].msg_hdr, received, monotonic_from_real_ns);
  }
  return static_cast<unsigned>(count);
}

void CanSocket::note_control(msghdr& header, CanReceived& received, std::int64_t monotonic_from_real_ns) noexcept {
  const std::int64_t now = now_ns(CLOCK_MONOTONIC);
  received.arrival_ns = now;
  for (cmsghdr* part = CMSG_FIRSTHDR(&header); part != nullptr; part = CMSG_NXTHDR(&header, part)) {
    if (part->cmsg_level != SOL_SOCKET) continue;
    if (part->cmsg_type == SO_TIMESTAMPNS) {
      timespec stamp{};
      std::memcpy(&stamp, CMSG_DATA(part), sizeof stamp);
      const std::int64_t arrival = stamp.tv_sec * kSecond_ns + stamp.tv_nsec + monotonic_from_real_ns;
      // If the wall clock was set between the stamp and now, the stamp is invalid.
      if (arrival <= now && arrival > now - kSecond_ns) received.arrival_ns = arrival;
    } else if (part->cmsg_type == SO_RXQ_OVFL) {
      std::memcpy(&lost_, CMSG_DATA(part), sizeof lost_);
    }
  }
}

bool CanSocket::wait(std::chrono::nanoseconds bound) noexcept {
  pollfd poll{socket_, POLLIN, 0};
  const timespec timeout{bound.count() / kSecond_ns, bound.count() % kSecond_ns};
  return ppoll(&poll, 1, &timeout, nullptr) > 0;
}

int CanSocket::send(std::uint32_t id, std::span<const std::byte> data, bool as_fd) noexcept {
  canfd_frame frame{};
  frame.can_id = id;
  frame.len = static_cast<__u8>(data.size());
  const bool fd = as_fd || data.size() > CAN_MAX_DLEN;
  if (fd) frame.flags = CANFD_BRS;
  std::memcpy(frame.data, data.data(), data.size());
  const std::size_t size = fd ? CANFD_MTU : CAN_MTU;
  return ::send(socket_, &frame, size, MSG_DONTWAIT) == static_cast<ssize_t>(size) ? 0 : errno;
}

}  // namespace tactus::firmware
