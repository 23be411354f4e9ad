// Parses which GPIO lines the host uses, from the text of `--gpio`.
//
//   chip=gpiochip0,estop=3-low,enable=4,probe=5,heartbeat=6
// The chip by name, path or label; each line by its offset on the chip. Every line is optional, at least one is needed.
// `-low` after an offset: the line is active low. Wire an e-stop with a normally closed contact so that a broken wire
// reads as stop: contact to ground, pull-up, active high. Thread: [setup].
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
  std::optional<GpioLine> estop{};      // in: status of the e-stop
  std::optional<GpioLine> enable{};     // out: drives are enabled
  std::optional<GpioLine> probe{};      // out: active while tick() runs, for an oscilloscope
  std::optional<GpioLine> heartbeat{};  // out: toggles every tick, for an external watchdog
};

inline constexpr unsigned kMaxGpioOffset = 1023;

// An error is one line: what was given and what is accepted.
Result<GpioOptions> parse_gpio_options(std::string_view text);

}  // namespace tactus::hal
