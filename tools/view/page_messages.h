// Messages from a page, as JSON: {"ack": N}, {"ask": "disarm"} or {"ask": "seek", "value": 2.5}. Anything else is
// refused, and so are longer messages, and more of them, than the bounds below.
//
// Pure; the caller gives the time. Thread: one. Bound: kLongestMessage bytes, kMaxMessages a second.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "rt/base/result.h"

namespace tactus::view {

inline constexpr std::size_t kLongestMessage = 256;
inline constexpr std::uint32_t kMaxMessages = 250;  // a second

struct PageMessage {
  std::uint32_t acknowledged{0};  // 0: the message is a request
  std::string ask;  // disarm, stop, reset, arm, rearm; play, pause, tick, cycle, back, seek, pace; take, rest
  std::optional<std::array<double, 6>> hand{};  // m, rad: target of the hand, relative to where it was taken
  double value{0};                              // seek: s of the tape; pace: times real time, 0 as fast as it goes
};

// Error: one line that says what is accepted.
Result<PageMessage> parse_message(std::string_view text);

// True for a request that can give force on a real device: allowed only with --allow-force. A request that takes force
// away is always allowed.
bool gives_force(std::string_view ask) noexcept;

class MessageRate {
 public:
  // False: this message is one too many in its second.
  bool admits(std::int64_t now_ns) noexcept {
    const std::int64_t second = now_ns / 1'000'000'000;
    if (second != second_) count_ = 0;
    second_ = second;
    return ++count_ <= kMaxMessages;
  }

 private:
  std::int64_t second_{0};
  std::uint32_t count_{0};
};

}  // namespace tactus::view
