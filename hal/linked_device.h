// A real device: implements HapticDevice, which the loop drives, on the frames of a link.
//
// One read() takes the newest state frame from the link; a state frame that fails its check is counted and never
// becomes a sample. One write() encodes a command frame and passes it to the link. Neither waits, except within the
// link's bound on receive(). The input guard decides how to react to a missing, corrupt or implausible frame.
// Thread: construction [setup]; read(), write() [rt] by the haptic thread; the accessors by that thread, or after it
// ended. No allocation, no lock, no throw. Frame: the device's. Units: SI. The link outlives the device.
#pragma once

#include <algorithm>

#include "hal/frame_codec.h"
#include "hal/frame_link.h"
#include "hal/profiles.h"

namespace tactus::hal {

// Since construction. Every read is counted in exactly one of the first four.
struct LinkedDeviceCounters {
  std::uint64_t fresh{0};         // reads with a valid frame, that is a new sample
  std::uint64_t missing{0};       // reads without a new frame
  std::uint64_t corrupt{0};       // reads of a frame that failed its check
  std::uint64_t disconnected{0};  // reads while the link was disconnected
  std::uint64_t superseded{0};    // frames dropped because a newer one had arrived
  std::uint64_t not_sent{0};      // commands that the link refused
};

template <FrameLink Link>
class LinkedDevice {
 public:
  // [setup] `period_ns`: the control period of host and device.
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
    if (!link_->connected()) {  // even if a last frame arrived just before the disconnect
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
  // CLOCK_MONOTONIC arrival time of the newest fresh sample; 0 before the first. The age of a force is the time of its
  // write() minus this.
  std::int64_t newest_arrival_ns() const noexcept { return newest_arrival_ns_; }
  // Why the last received frame was rejected; kNone if it was accepted.
  firmware::DecodeError last_decode_error() const noexcept { return last_decode_error_; }

 private:
  haptics::DeviceProperties properties_;
  FrameCodec codec_;
  Link* link_;
  haptics::DeviceSample sample_;  // the newest valid one
  std::int64_t newest_arrival_ns_{0};
  firmware::DecodeError last_decode_error_{firmware::DecodeError::kNone};
  LinkedDeviceCounters counters_;
};

}  // namespace tactus::hal
