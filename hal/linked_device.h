// A real device: frames that a link moves, as the HapticDevice that the loop drives.
//
// One read() takes the newest state frame from the link; a state frame that fails its check is counted and never
// becomes a sample. One write() makes a command frame and hands it to the link. Neither waits: how long receive() may
// take is the link's promise. What to do about a missing, broken or hostile frame is the input guard's to decide.
// Thread: construction [setup]; read(), write() [rt] by the haptic thread; the accessors by that thread, or after it
// ended. No allocation, no lock, no throw. Frame: the device's. Units: SI. The link outlives the device.
#pragma once

#include <algorithm>

#include "hal/frame_codec.h"
#include "hal/frame_link.h"
#include "hal/profiles.h"

namespace tactus::hal {

// Since construction: every read is in exactly one of the first four.
struct LinkedDeviceCounters {
  std::uint64_t fresh{0};         // a whole frame, a new sample
  std::uint64_t missing{0};       // nothing new
  std::uint64_t corrupt{0};       // a frame that failed its check
  std::uint64_t disconnected{0};  // the link said that the device is gone
  std::uint64_t superseded{0};    // frames that came and were dropped for a newer one
  std::uint64_t not_sent{0};      // commands that the link did not take on
};

template <FrameLink Link>
class LinkedDevice {
 public:
  // [setup] `period_ns`: the control period of both ends.
  LinkedDevice(const DeviceProfile& profile, std::int64_t period_ns, Link& link) noexcept
      : properties_(profile.properties),
        codec_(profile.kinematics, profile.quantum, profile.properties.has_rotation),
        link_(&link) {
    properties_.delay_s = static_cast<double>(profile.transport_delay_ticks) * static_cast<double>(period_ns) * 1e-9;
  }

  const haptics::DeviceProperties& properties() const noexcept { return properties_; }

  void read(haptics::DeviceInput& input) noexcept {
    using haptics::ReadStatus;
    std::array<std::byte, firmware::kMaxFrameSize> buffer;
    const ReceivedFrame frame = link_->receive(buffer);
    counters_.superseded += frame.superseded;
    if (!link_->connected()) {  // also for a frame that came just before: what follows it will not come
      input.status = ReadStatus::kDisconnected;
      ++counters_.disconnected;
    } else if (frame.size == 0) {
      input.status = ReadStatus::kMissing;
      ++counters_.missing;
    } else {
      const auto bytes = std::span<const std::byte>(buffer).first(std::min(frame.size, buffer.size()));
      last_decode_error_ = codec_.decode(bytes, sample_);
      const bool whole = last_decode_error_ == firmware::DecodeError::kNone;
      input.status = whole ? ReadStatus::kFresh : ReadStatus::kCorrupt;
      ++(whole ? counters_.fresh : counters_.corrupt);
      if (whole) newest_arrival_ns_ = frame.arrival_ns;
    }
    input.sample = sample_;
  }

  void write(const haptics::DeviceCommand& command) noexcept {
    std::array<std::byte, firmware::kCommandFrameSize> bytes{};
    codec_.encode(command, bytes);
    if (!link_->send(bytes)) ++counters_.not_sent;
  }

  Link& link() const noexcept { return *link_; }
  const LinkedDeviceCounters& counters() const noexcept { return counters_; }
  // CLOCK_MONOTONIC when the sample of the newest fresh read came in; 0 before the first. The age of a force is the
  // time of its write() minus this.
  std::int64_t newest_arrival_ns() const noexcept { return newest_arrival_ns_; }
  // Of the last frame that came: why it was refused.
  firmware::DecodeError last_decode_error() const noexcept { return last_decode_error_; }

 private:
  haptics::DeviceProperties properties_;
  FrameCodec codec_;
  Link* link_;
  haptics::DeviceSample sample_;  // the last one that came
  std::int64_t newest_arrival_ns_{0};
  firmware::DecodeError last_decode_error_{firmware::DecodeError::kNone};
  LinkedDeviceCounters counters_;
};

}  // namespace tactus::hal
