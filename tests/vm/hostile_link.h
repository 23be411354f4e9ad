// A device's link that lies: what passes through it can be lost, broken, repeated, out of all bounds, of the wrong
// length, too much or nothing at all. Around any DeviceLink; its own faults only, the link's stay as they are.
//
// Each fault holds for a number of frames that is set from outside. Also reports of what the host sent the
// largest effort that a whole command asked for. Thread: one, the control period's.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "firmware/board.h"

namespace tactus::vm {

// Frames that each fault still holds for.
struct LinkFaults {
  std::uint64_t lost_states{0}, corrupt_states{0}, repeated_states{0}, wild_states{0}, odd_sizes{0}, silence{0};
  std::uint64_t lost_commands{0}, corrupt_commands{0}, repeated_commands{0};
  std::uint64_t idle_commands{0};  // that want FORCE and come as wanting IDLE
  // Commands after which another one follows in the same period: an older one, a broken one, an older one with NaN.
  std::uint64_t old_commands{0}, broken_followers{0}, nan_followers{0};
  std::uint64_t babble{0};      // periods in which eight frames of rubbish follow the true one
  std::uint64_t told_fault{0};  // not a number of frames: all states tell BRAKE and this fault, until it is 0
};

template <firmware::DeviceLink Link>
class HostileLink {
 public:
  HostileLink(Link& link, std::uint64_t seed) : link_(link), random_(seed) {}

  LinkFaults faults;

  std::size_t receive_command(std::span<std::byte, firmware::kMaxFrameSize> buffer) noexcept {
    if (follower_ != Follower::kNone) return follow(std::exchange(follower_, Follower::kNone), buffer);
    while (const std::size_t size = link_.receive_command(buffer)) {
      note(buffer.first(size));
      if (holds(faults.repeated_commands) && last_size_ > 0) {
        std::copy_n(last_command_.begin(), last_size_, buffer.begin());
        return last_size_;
      }
      std::copy_n(buffer.begin(), size, last_command_.begin());
      last_size_ = size;
      if (size == firmware::kCommandFrameSize) {
        std::copy_n(buffer.begin(), size, sent_[++sent_count_ % sent_.size()].begin());
        if (sent_count_ > sent_.size()) follower_ = choose_follower();
      }
      want_idle(buffer.first(size));
      if (holds(faults.corrupt_commands)) flip_bits(buffer.first(size));
      if (!holds(faults.lost_commands)) return size;
    }
    return 0;
  }

  void send_state(std::span<const std::byte> frame) noexcept {
    if (holds(faults.silence) || holds(faults.lost_states)) return;
    std::array<std::byte, firmware::kMaxFrameSize> bytes{};
    std::size_t size = std::min(frame.size(), bytes.size());
    std::copy_n(frame.begin(), size, bytes.begin());
    if (holds(faults.repeated_states) && last_state_size_ > 0) {
      size = last_state_size_;
      bytes = last_state_;
    } else {
      last_state_size_ = size;
      last_state_ = bytes;
    }
    if (faults.told_fault != 0) tell_fault(std::span(bytes).first(size));
    if (holds(faults.wild_states)) make_wild(std::span(bytes).first(size));
    if (holds(faults.corrupt_states)) flip_bits(std::span(bytes).first(size));
    if (holds(faults.odd_sizes)) size = random() % (firmware::kMaxFrameSize + 1);
    link_.send_state(std::span(bytes).first(size));
    if (holds(faults.babble))
      for (int i = 0; i < 8; ++i) send_rubbish();
  }

  bool receive_service(firmware::ServiceMessage& message) noexcept { return link_.receive_service(message); }
  void reply_service(const firmware::ServiceMessage& message) noexcept { link_.reply_service(message); }

  // Of whole commands that came: how many, and the largest effort of an axis [N, N m].
  std::uint64_t commands() const noexcept { return commands_; }
  float largest_effort() const noexcept { return largest_effort_; }
  bool saw_effort_not_finite() const noexcept { return not_finite_; }

 private:
  static bool holds(std::uint64_t& frames) noexcept { return frames > 0 && frames-- > 0; }

  // What follows a command that came, where told to: the device must obey none of these.
  enum class Follower { kNone, kOld, kBroken, kNan };

  Follower choose_follower() noexcept {
    if (holds(faults.old_commands)) return Follower::kOld;
    if (holds(faults.broken_followers)) return Follower::kBroken;
    return holds(faults.nan_followers) ? Follower::kNan : Follower::kNone;
  }

  std::size_t follow(Follower follower, std::span<std::byte, firmware::kMaxFrameSize> buffer) noexcept {
    const auto& frame =
        follower == Follower::kBroken ? sent_[sent_count_ % sent_.size()] : sent_[(sent_count_ + 1) % sent_.size()];
    const auto bytes = buffer.template first<firmware::kCommandFrameSize>();
    std::copy(frame.begin(), frame.end(), bytes.begin());
    if (follower == Follower::kBroken) bytes[bytes.size() / 2] ^= std::byte{1};
    firmware::CommandFrame command;
    if (follower == Follower::kNan && firmware::decode_command(bytes, command) == firmware::DecodeError::kNone) {
      command.effort.fill(std::numeric_limits<float>::quiet_NaN());
      firmware::encode_command(command, bytes);
    }
    return bytes.size();
  }

  void want_idle(std::span<std::byte> bytes) noexcept {
    firmware::CommandFrame command;
    if (bytes.size() != firmware::kCommandFrameSize ||
        firmware::decode_command(bytes, command) != firmware::DecodeError::kNone ||
        command.wanted != firmware::State::kForce || !holds(faults.idle_commands))
      return;
    command.wanted = firmware::State::kIdle;
    firmware::encode_command(command, bytes.template first<firmware::kCommandFrameSize>());
  }

  void note(std::span<const std::byte> bytes) noexcept {
    firmware::CommandFrame command;
    if (firmware::decode_command(bytes, command) != firmware::DecodeError::kNone) return;
    ++commands_;
    for (const float effort : command.effort) {
      if (!std::isfinite(effort)) not_finite_ = true;
      largest_effort_ = std::fmax(largest_effort_, std::fabs(effort));
    }
  }

  void flip_bits(std::span<std::byte> bytes) noexcept {
    for (unsigned flips = 1 + static_cast<unsigned>(random() % 8); flips > 0 && !bytes.empty(); --flips) {
      const std::uint64_t bit = random() % (8 * bytes.size());
      bytes[bit / 8] ^= static_cast<std::byte>(1u << (bit % 8));
    }
  }

  void tell_fault(std::span<std::byte> bytes) noexcept {
    firmware::StateFrame frame;
    if (bytes.size() != firmware::kStateFrameSize ||
        firmware::decode_state(bytes, frame) != firmware::DecodeError::kNone)
      return;
    frame.state = firmware::State::kBrake;
    frame.fault = static_cast<std::uint16_t>(faults.told_fault);
    firmware::encode_state(frame, bytes.template first<firmware::kStateFrameSize>());
  }

  // Every field wild under a right check; a state number that exists, so that the frame is believed.
  void make_wild(std::span<std::byte> bytes) noexcept {
    firmware::StateFrame frame;
    if (bytes.size() != firmware::kStateFrameSize ||
        firmware::decode_state(bytes, frame) != firmware::DecodeError::kNone)
      return;
    for (std::int32_t& count : frame.counts) count = static_cast<std::int32_t>(random());
    frame.time_us = random();
    frame.limits = static_cast<std::uint16_t>(random());
    frame.fault = static_cast<std::uint16_t>(random());
    frame.missed_commands = static_cast<std::uint8_t>(random());
    frame.echoed_sequence = static_cast<std::uint32_t>(random());
    if (random() % 4 == 0) frame.sequence = static_cast<std::uint32_t>(random());
    firmware::encode_state(frame, bytes.template first<firmware::kStateFrameSize>());
  }

  void send_rubbish() noexcept {
    std::array<std::byte, firmware::kMaxFrameSize> bytes;
    for (std::byte& byte : bytes) byte = static_cast<std::byte>(random());
    link_.send_state(std::span(bytes).first(random() % (bytes.size() + 1)));
  }

  // splitmix64 (Steele, Lea, Flood 2014).
  std::uint64_t random() noexcept {
    std::uint64_t z = random_ += 0x9e3779b97f4a7c15ull;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
  }

  Link& link_;
  std::uint64_t random_, commands_{0};
  std::array<std::byte, firmware::kMaxFrameSize> last_command_{}, last_state_{};
  std::size_t last_size_{0}, last_state_size_{0};
  std::array<std::array<std::byte, firmware::kCommandFrameSize>, 8> sent_{};  // the last ones
  std::size_t sent_count_{0};
  Follower follower_{Follower::kNone};
  float largest_effort_{0};
  bool not_finite_{false};
};

}  // namespace tactus::vm
