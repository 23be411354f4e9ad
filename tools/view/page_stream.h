// What one page gets: messages in the wire format (wire.h), never more than two that it has not acknowledged, the
// newest frame first; frames that came too soon are dropped and counted, ticks wait.
//
// Pure: no socket, no clock. Thread: one. Bound: kMaxTicks ticks wait; older ones are lost and counted.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/publication/watcher.h"
#include "tools/view/wire.h"

namespace tactus::view {

inline constexpr std::uint32_t kMaxUnacknowledged = 2;
inline constexpr std::size_t kMaxTicks = 4096;

class PageStream {
 public:
  // A new frame of the run is there; take() sends it, unless the next one comes first.
  void offer_frame() noexcept;
  void offer_ticks(const std::vector<publication::TickEntry>& ticks, std::uint64_t lost);
  // Call when the ticks that follow are of another time. Drops the ticks that wait.
  void restart() noexcept;
  // Call when the page has acknowledged this message, and with it all before.
  void acknowledge(std::uint32_t number) noexcept;

  // True: there is something new, and the page can take it.
  bool ready() const noexcept;
  // The next message; `frame` is the run's newest, `now_ns` of the monotonic clock.
  std::string take(const publication::Frame& frame, std::int64_t now_ns);

  std::uint32_t dropped() const noexcept { return dropped_; }

 private:
  struct Sent {  // of a body, as the page has it
    publication::Position position;
    publication::Rotation rotation;
    std::uint8_t role{0};
  };
  std::vector<std::uint32_t> moved_bodies(const publication::Frame& frame) const;
  void put_bodies(const publication::Frame& frame, WireHeader& header, std::string& blocks);
  void put_roles(const publication::Frame& frame, WireHeader& header, std::string& blocks);

  bool frame_waits_{false}, first_{true}, restarts_{false};
  std::uint32_t sent_{0}, acknowledged_{0}, dropped_{0}, lost_ticks_{0};
  std::vector<Sent> state_;
  std::vector<float> ticks_;        // kChannels each
  std::int64_t newest_woke_ns_{0};  // of the last of them; 0: not measured
};

}  // namespace tactus::view
