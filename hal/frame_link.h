// The host's end of a link: moves frames between a device and the haptic thread without interpreting them.
//
// A link carries whole frames of firmware/protocol.h. If several have arrived since the last receive(), it returns only
// the newest and counts the others. Each kind of link is one class; LinkedDevice makes a HapticDevice of any of them.
// Thread: open() and call() [setup] and normal threads; start() [setup]; the rest [rt], by the haptic thread alone: no
// wait beyond the link's stated bound, no allocation, no lock, no throw.
#pragma once

#include <chrono>
#include <concepts>
#include <cstdint>
#include <span>

#include "firmware/service.h"
#include "rt/base/result.h"

namespace tactus::hal {

struct ReceivedFrame {
  std::size_t size{0};          // bytes; 0: nothing new, `buffer` is unchanged
  std::int64_t arrival_ns{0};   // CLOCK_MONOTONIC, taken as near to the wire as the link can
  std::uint32_t superseded{0};  // older frames that were dropped for this one
};

// Since start(). Every frame that a link drops is counted in one of them. 64 bits never wrap in practice.
struct LinkCounters {
  std::uint64_t received{0};         // whole frames from the device, returned by receive() or not
  std::uint64_t superseded{0};       // received, replaced by a newer one before the next receive()
  std::uint64_t malformed{0};        // received data that does not form a frame
  std::uint64_t sent{0};             // frames that the link accepted
  std::uint64_t send_superseded{0};  // commands replaced by a newer one before they left
  std::uint64_t send_failed{0};      // refused by the driver, or the device was disconnected
  std::uint64_t errors{0};           // error frames, failed transfers
  std::uint64_t disconnects{0};      // unplugged, bus-off, interface down
};

template <class L>
concept FrameLink = requires(L link, const L& constant, std::span<std::byte, firmware::kMaxFrameSize> buffer,
                             std::span<const std::byte> frame, const firmware::ServiceMessage& request) {
  { link.receive(buffer) }
  noexcept->std::same_as<ReceivedFrame>;
  { link.send(frame) }
  noexcept->std::same_as<bool>;  // false: refused, and counted
  { constant.connected() }
  noexcept->std::same_as<bool>;
  { constant.counters() }
  noexcept->std::same_as<LinkCounters>;
  // [setup] [normal] One request to the device and its reply; never from the haptic thread. An error says what to do.
  { link.call(request, std::chrono::milliseconds{}) } -> std::same_as<Result<firmware::ServiceMessage>>;
};

}  // namespace tactus::hal
