// Encoding of the control frames and service messages on CAN: identifiers and fragments, for both ends.
//
// Identifier: 11 bits, function (high four) and node id 1 to 127 (low seven); the lower one wins the bus:
//   1 command 0   2 command 1   3 state 0   4 state 1   5 state 2   6 status   7 service request   8 service reply
// There is no emergency identifier: every state contains state and fault number. Little-endian, bit 0 first.
//
// CAN FD (bit rate switched): each frame of protocol.h is one CAN frame, state as function 3, 56 bytes and 8 zeros;
// command as function 1, 40 bytes and 8 zeros. Service messages are classic frames of 8 bytes on either bus.
//
// Classic: frames of 8 bytes, each one 64-bit number. CAN's own CRC-15 replaces the CRC-32C.
//   bits     0-21      22-43     44-47           48-63
//   state 0  count 0   count 1   sequence 0-3    48-49 state, 50-55 fault, 56-63 time bits 3-10 [8 us]
//   state 1  count 2   count 3   sequence 0-3    48-63 limit bits
//   state 2  count 4   count 5   sequence 0-3    48-51 sequence 4-7, 52-55 missed, 56-63 echoed sequence 0-7
//   status   0-15 sequence, 16-47 time [us], 48-55 buttons, 56-63 missed
//   bits     0-15      16-31     32-47           48-51 exponent e, 52-59 sequence 0-7, and
//   cmd 0    effort 0  effort 1  effort 2        60-61 wanted state, 62 re-arm, 63 zero
//   cmd 1    effort 3  effort 4  effort 5        60-63 sequence 8-11
// Counts are signed and saturate at +-(2^21 - 1); missed saturates. An effort is a signed number m and means m 2^(e-20)
// N or N m: three efforts share the smallest e that can represent the largest of them, so that no full scale has to be
// configured; -32768 means "not finite", which the device rejects. Beyond 1023 the three are scaled down together. The
// status is sent after each state whose sequence is a multiple of ten, and when the buttons change. Both ends rebuild
// whole frames: sequence and time are extended from the last ones to the value nearest to the expected one, after a gap
// only forwards. A status older than the newest state is a copy and ignored. Two such statuses that are apart in time
// as their sequences require come from a device that was reset: sequence and time then go back to theirs.
//
// Bus load and possible rates: can_bus_load.h.
// Thread: [any], one owner per object; no allocation, bounded.
#pragma once

#include "firmware/service.h"

namespace tactus::firmware {

enum class CanFunction : std::uint8_t {
  kCommand0 = 1,
  kCommand1 = 2,
  kState0 = 3,
  kState1 = 4,
  kState2 = 5,
  kStatus = 6,
  kServiceRequest = 7,
  kServiceReply = 8,
};

inline constexpr std::uint8_t kMaxCanNode = 127;
inline constexpr std::size_t kClassicSize = 8, kFdStateSize = 64, kFdCommandSize = 48;
inline constexpr unsigned kStateFragments = 3, kCommandFragments = 2;
inline constexpr std::uint32_t kStatusPeriods = 10;
inline constexpr std::int32_t kMaxCanCount = (1 << 21) - 1;

constexpr std::uint32_t can_id(CanFunction function, std::uint8_t node) noexcept {
  return (static_cast<std::uint32_t>(function) << 7) | node;
}
constexpr CanFunction can_function(std::uint32_t id) noexcept { return static_cast<CanFunction>((id >> 7) & 0xfu); }

using CanData = std::array<std::byte, kClassicSize>;
struct CanFragment {
  CanFunction function{};
  CanData data{};
};

// Splits a state into fragments, in the order of sending; device's end.
class StateSplitter {
 public:
  // Returns the number of fragments in `out`: three, or four with a status.
  unsigned split(const StateFrame& frame, std::array<CanFragment, kStateFragments + 1>& out) noexcept;

 private:
  bool status_sent_{false};
  std::uint8_t buttons_{0};
};

std::array<CanFragment, kCommandFragments> split_command(const CommandFrame& frame) noexcept;

// Collects received fragments into complete sets. A fragment with another key than the waiting ones, or a repeated one,
// starts a new set; an incomplete set is dropped after kMaxLooks calls of look().
class FragmentSet {
 public:
  // Half the range of a state's key, so that the key cannot repeat meanwhile. More than one period, because a slow
  // interrupt or other nodes' frames may separate fragments that were sent together.
  static constexpr unsigned kMaxLooks = 8;

  // True: the set of `count` fragments is complete, and empty again.
  bool add(unsigned index, unsigned count, std::uint8_t key, const CanData& data) noexcept;
  void look() noexcept;
  void forget() noexcept;
  std::uint64_t word(unsigned index) const noexcept { return words_[index]; }
  std::uint32_t incomplete() const noexcept { return incomplete_; }  // dropped sets; wraps

 private:
  std::array<std::uint64_t, kStateFragments> words_{};
  unsigned present_{0}, looks_{0};
  std::uint8_t key_{0};
  std::uint32_t incomplete_{0};
};

// Rebuilds states from fragments; host's end.
class StateAssembler {
 public:
  static constexpr unsigned kGapLooks = 64;  // look()s without a frame after which the 8-bit sequence may have wrapped

  explicit StateAssembler(std::uint32_t period_us) noexcept : period_us_(period_us) {}

  // Once per period, before the fragments received in it.
  void look() noexcept;
  // True: `frame` is a complete new frame. `data` of another size or function: malformed, nothing changes.
  bool accept(CanFunction function, std::span<const std::byte> data, StateFrame& frame) noexcept;
  // Call after the loss of an unknown number of frames: drops waiting fragments; the sequence continues forwards.
  void forget() noexcept;
  // The sequence of the last command sent; the echoed sequence is rebuilt from it.
  void sent(std::uint32_t sequence) noexcept { sent_ = sequence; }

  std::uint32_t incomplete() const noexcept { return set_.incomplete(); }
  std::uint32_t malformed() const noexcept { return malformed_; }  // wraps

 private:
  void take_status(std::uint64_t word) noexcept;
  bool follows_old_status(std::uint64_t word) noexcept;
  void rebuild(StateFrame& frame) noexcept;
  void continue_sequence_and_time(StateFrame& frame) noexcept;

  FragmentSet set_;
  std::uint32_t period_us_;
  std::uint32_t sequence_{0}, sent_{0}, echoed_{0}, malformed_{0};
  std::uint64_t time_us_{0};
  std::uint64_t old_status_{0};  // the last status older than the newest state; 0: none
  unsigned silent_looks_{0};
  bool state_gap_{true}, status_gap_{true};  // the next state, status is extended forwards only
  std::uint8_t buttons_{0}, status_missed_{0};
};

// Rebuilds commands from fragments; device's end.
class CommandAssembler {
 public:
  void look() noexcept { set_.look(); }
  bool accept(CanFunction function, std::span<const std::byte> data, CommandFrame& frame) noexcept;
  void forget() noexcept { set_.forget(); }
  std::uint32_t incomplete() const noexcept { return set_.incomplete(); }
  std::uint32_t malformed() const noexcept { return malformed_; }

 private:
  FragmentSet set_;
  std::uint32_t sequence_{0}, malformed_{0};
};

// Copies a frame into the data of a CAN FD frame, `out`, which is at least as large, and pads it with zeros.
void pad_fd(std::span<const std::byte> frame, std::span<std::byte> out) noexcept;
// The frame of `size` bytes in data of `padded` bytes; empty if the length differs or the padding is not zero.
std::span<const std::byte> unpad_fd(std::span<const std::byte> data, std::size_t padded, std::size_t size) noexcept;

}  // namespace tactus::firmware
