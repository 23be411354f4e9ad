// What the kernel says about a CAN interface: there, up, its bit rates, its controller's state.
//
// Over rtnetlink, as `ip -details link show` does; no privilege needed. Thread: [setup] and normal threads.
// Bound: one question and one answer, at most kAnswerWait.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "rt/base/result.h"

namespace tactus::hal {

inline constexpr std::chrono::milliseconds kAnswerWait{500};

struct CanInterface {
  enum class Controller : std::uint8_t { kActive, kWarning, kPassive, kBusOff, kStopped, kSleeping, kUnknown };

  std::string name;
  bool is_can{false};
  bool is_virtual{false};  // no controller behind it: vcan
  bool up{false};
  bool fd{false};                               // its MTU takes CAN FD frames
  Controller controller{Controller::kUnknown};  // unknown: a virtual one
  std::uint32_t bit_per_s{0};                   // 0: a virtual one, or not set
  std::uint32_t data_bit_per_s{0};              // of FD's fast part; 0: none
  std::uint32_t restart_ms{0};                  // after bus-off; 0: never by itself
  std::uint16_t tx_errors{0}, rx_errors{0};
};

// An error: no such interface (the message names those that there are), or the kernel gives no answer.
Result<CanInterface> find_can_interface(const std::string& name);

// Can this interface carry frames now? `fd`: as CAN FD. The message says what to type.
Status check_can_interface(const CanInterface& interface, bool fd);
// Do one period's control frames fit its bit rate, with every bit stuffed that can be? Good if the rate is not known.
Status check_can_rate(const CanInterface& interface, bool fd, std::chrono::nanoseconds period);

}  // namespace tactus::hal
