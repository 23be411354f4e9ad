// Queries the kernel about a CAN interface: existence, up or down, bit rates, controller state.
//
// Over rtnetlink, as `ip -details link show` does; no privilege needed. Thread: [setup] and normal threads.
// Bound: one request and one reply, at most kAnswerWait.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

#include "rt/base/result.h"

namespace tactus::hal {

inline constexpr std::chrono::milliseconds kAnswerWait{500};

struct CanInterface {
  enum class Controller : std::uint8_t { kActive, kWarning, kPassive, kBusOff, kStopped, kSleeping, kUnknown };

  std::string name;
  bool is_can{false};
  bool is_virtual{false};  // no controller behind it: vcan
  bool up{false};
  bool fd{false};                               // its MTU allows CAN FD frames
  Controller controller{Controller::kUnknown};  // unknown: virtual interface
  std::uint32_t bit_per_s{0};                   // 0: virtual interface, or not set
  std::uint32_t data_bit_per_s{0};              // FD data phase; 0: none
  std::uint32_t restart_ms{0};                  // delay of the automatic restart after bus-off; 0: none
  std::uint16_t tx_errors{0}, rx_errors{0};
};

// The name alone: not empty, at most 15 letters (the kernel's IFNAMSIZ without its end). Error: a phrase about it.
Status check_can_name(std::string_view name);

// Errors: no such interface (the message lists the existing ones), or no reply from the kernel.
Result<CanInterface> find_can_interface(const std::string& name);

// Checks that this interface can carry frames now. `fd`: as CAN FD. The message says what to type.
Status check_can_interface(const CanInterface& interface, bool fd);
// Checks that one period's control frames fit the bit rate with worst-case bit stuffing. Good if the rate is unknown.
Status check_can_rate(const CanInterface& interface, bool fd, std::chrono::nanoseconds period);

}  // namespace tactus::hal
