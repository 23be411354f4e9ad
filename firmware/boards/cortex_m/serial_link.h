// The device's end of a serial line: the DeviceLink of firmware/board.h over any port that transfers bytes.
//
// The line carries frames of protocol.h and service.h, encoded as in cobs.h. At 1 kHz a period has a command of 42
// bytes in one direction and a state of 58 in the other, 76 with a service reply, at 10 bits per byte: 1 Mbit/s is the
// slowest sufficient rate. Thread: received() and next_to_send() in the port's interrupt handler(s); the rest the
// control period's, [rt]. Bound: rings of 256 bytes. A byte that does not fit the receive ring is dropped and counted,
// and its frame fails its CRC; a frame that does not fit the send ring is dropped whole and counted: the state's
// sequence shows the gap.
#pragma once

#include <algorithm>
#include <atomic>

#include "firmware/board.h"
#include "firmware/boards/cortex_m/cobs.h"

namespace tactus::firmware {

// One producer, one consumer; either may be an interrupt handler.
template <std::size_t kSize>
class ByteRing {
  static_assert((kSize & (kSize - 1)) == 0);

 public:
  bool push(std::byte b) noexcept {
    const std::uint32_t end = end_.load(std::memory_order_relaxed);
    if (end - begin_.load(std::memory_order_acquire) >= kSize) return false;
    bytes_[end % kSize] = b;
    end_.store(end + 1, std::memory_order_release);
    return true;
  }
  bool pop(std::byte& b) noexcept {
    const std::uint32_t begin = begin_.load(std::memory_order_relaxed);
    if (begin == end_.load(std::memory_order_acquire)) return false;
    b = bytes_[begin % kSize];
    begin_.store(begin + 1, std::memory_order_release);
    return true;
  }
  std::size_t size() const noexcept {
    return end_.load(std::memory_order_acquire) - begin_.load(std::memory_order_acquire);
  }

 private:
  std::array<std::byte, kSize> bytes_{};
  std::atomic<std::uint32_t> begin_{0}, end_{0};
};

// transmit(): notifies the port that bytes wait in the link; its handler must fetch them with next_to_send().
template <class P>
concept SerialPort = requires(P port) {
  { port.transmit() }
  noexcept->std::same_as<void>;
};

template <SerialPort Port>
class SerialLink {
 public:
  static constexpr std::size_t kRingSize = 256;
  static constexpr unsigned kWaitingCommands = 8;  // more than fit a ring; beyond that the newest are kept

  explicit constexpr SerialLink(Port& port) noexcept : port_(port) {}

  void received(std::byte b) noexcept {
    if (!incoming_.push(b)) overflow_.store(overflow_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  }
  bool next_to_send(std::byte& b) noexcept { return outgoing_.pop(b); }

  std::size_t receive_command(std::span<std::byte, kMaxFrameSize> buffer) noexcept {
    take_received();
    if (waiting_ > 0) {
      const auto& command = commands_[(next_free_ + kWaitingCommands - waiting_--) % kWaitingCommands];
      std::copy(command.begin(), command.end(), buffer.begin());
      return command.size();
    }
    std::copy_n(other_.begin(), other_size_, buffer.begin());
    const std::size_t size = other_size_;
    other_size_ = 0;
    return size;
  }
  bool receive_service(ServiceMessage& message) noexcept {
    take_received();
    if (!asked_) return false;
    message = request_;
    asked_ = false;
    return true;
  }
  void send_state(std::span<const std::byte> frame) noexcept { send(frame); }
  void reply_service(const ServiceMessage& message) noexcept {
    std::array<std::byte, kServiceFrameSize> frame;
    encode_service(message, ServiceDirection::kReply, frame);
    send(frame);
  }

  std::uint32_t malformed() const noexcept { return reader_.malformed(); }
  std::uint32_t bytes_lost() const noexcept { return overflow_.load(std::memory_order_relaxed); }  // wraps
  std::uint32_t frames_not_sent() const noexcept { return not_sent_; }                             // wraps
  std::uint32_t requests_refused() const noexcept { return requests_refused_; }                    // wraps

 private:
  // Only the bytes present at the call, so at most one ring.
  void take_received() noexcept {
    std::byte b{};
    for (std::size_t left = incoming_.size(); left > 0 && incoming_.pop(b); --left)
      if (reader_.accept(b)) sort(reader_.frame());
  }
  // A frame of a request's size is checked here, any other by the controller, which counts rejected ones; of frames
  // that have no command's size either, only the last is kept. Of two waiting requests only the second gets a reply.
  void sort(std::span<const std::byte> frame) noexcept {
    if (frame.size() == kServiceFrameSize) {
      if (decode_service(frame, ServiceDirection::kRequest, request_) == DecodeError::kNone)
        asked_ = true;
      else
        ++requests_refused_;
      return;
    }
    if (frame.size() == kCommandFrameSize) {
      std::copy(frame.begin(), frame.end(), commands_[next_free_].begin());
      next_free_ = (next_free_ + 1) % kWaitingCommands;
      if (waiting_ < kWaitingCommands) ++waiting_;
      return;
    }
    std::copy(frame.begin(), frame.end(), other_.begin());
    other_size_ = frame.size();
  }
  void send(std::span<const std::byte> frame) noexcept {
    std::array<std::byte, kMaxStuffedSize> stuffed;
    const std::size_t size = stuff(frame, stuffed);
    if (size == 0 || kRingSize - outgoing_.size() < size) {
      ++not_sent_;
      return;
    }
    for (std::size_t i = 0; i < size; ++i) (void)outgoing_.push(stuffed[i]);
    port_.transmit();
  }

  Port& port_;
  ByteRing<kRingSize> incoming_, outgoing_;
  std::atomic<std::uint32_t> overflow_{0};
  FrameReader reader_;
  std::array<std::array<std::byte, kCommandFrameSize>, kWaitingCommands> commands_{};
  unsigned next_free_{0}, waiting_{0};
  std::array<std::byte, kMaxFrameSize> other_{};
  std::size_t other_size_{0};
  ServiceMessage request_;
  bool asked_{false};
  std::uint32_t not_sent_{0}, requests_refused_{0};
};

}  // namespace tactus::firmware
