// The host's end of a link: what moves frames between a device and the haptic thread, without knowing what is in them.
//
// A link carries whole frames of firmware/protocol.h, newest first: of several that came since the last look only the
// newest is handed out, the others are counted. Each kind of link is one class; LinkedDevice makes a HapticDevice of
// any of them. Thread: open() and call() [setup] and normal threads; start() [setup]; the rest [rt], by the haptic
// thread alone: no wait beyond the link's stated bound, no allocation, no lock, no throw.
#pragma once

#include <chrono>
#include <concepts>
#include <cstdint>
#include <span>

#include "firmware/service.h"
#include "rt/base/result.h"

namespace tactus::hal {

struct ReceivedFrame {
  std::size_t size{0};          // 0: nothing new; `buffer` is as it was
  std::int64_t arrival_ns{0};   // CLOCK_MONOTONIC, as near to the wire as the link can tell
  std::uint32_t superseded{0};  // older frames that were dropped for this one
};

// Since start(). Every frame that a link drops is in one of them. They wrap never in a lifetime.
struct LinkCounters {
  std::uint64_t received{0};         // frames from the device, whole, handed out or not
  std::uint64_t superseded{0};       // received, replaced by a newer one before the haptic thread looked
  std::uint64_t malformed{0};        // bytes that the link itself could not make a frame of
  std::uint64_t sent{0};             // frames that the link took on
  std::uint64_t send_superseded{0};  // commands replaced by a newer one before they left
  std::uint64_t send_failed{0};      // refused by the driver, or the device was away
  std::uint64_t errors{0};           // error frames, failed transfers
  std::uint64_t disconnects{0};      // unplugged, bus-off, interface down
};

template <class L>
concept FrameLink = requires(L link, const L& constant, std::span<std::byte, firmware::kMaxFrameSize> buffer,
                             std::span<const std::byte> frame, const firmware::ServiceMessage& request) {
  { link.receive(buffer) }
  noexcept->std::same_as<ReceivedFrame>;
  { link.send(frame) }
  noexcept->std::same_as<bool>;  // false: not taken on, and counted
  { constant.connected() }
  noexcept->std::same_as<bool>;
  { constant.counters() }
  noexcept->std::same_as<LinkCounters>;
  // [setup] [normal] One question to the device and its answer; never from the haptic thread. An error says what to do.
  { link.call(request, std::chrono::milliseconds{}) } -> std::same_as<Result<firmware::ServiceMessage>>;
};

}  // namespace tactus::hal
