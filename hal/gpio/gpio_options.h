// Which GPIO lines the host uses, in the text form of `--gpio`.
//
//   chip=gpiochip0,estop=3-low,enable=4,probe=5,heartbeat=6
// The chip by name, path or label; each line by its offset on the chip, all optional, at least one. `-low` after an
// offset: active when the line is low. An e-stop with a contact that opens is best wired so that a broken wire reads as
// stop: contact to ground, pull-up, active when high. Thread: [setup].
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "rt/base/result.h"

namespace tactus::hal {

struct GpioLine {
  unsigned offset{0};
  bool active_low{false};
  friend bool operator==(const GpioLine&, const GpioLine&) = default;
};

struct GpioOptions {
  std::string chip{};
  std::optional<GpioLine> estop{};      // in: the stop's status
  std::optional<GpioLine> enable{};     // out: drives may be on
  std::optional<GpioLine> probe{};      // out: active while tick() runs, for an oscilloscope
  std::optional<GpioLine> heartbeat{};  // out: changes with every tick, for a watchdog outside
};

inline constexpr unsigned kMaxGpioOffset = 1023;

// One line on anything else: what was given and what is accepted.
Result<GpioOptions> parse_gpio_options(std::string_view text);

}  // namespace tactus::hal
