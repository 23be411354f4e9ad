// Analysis of records: frame losses, answer time of a command, age of the force, drift of the two clocks. Uses the
// records alone, one by one, so that a soak may have any length. Thread: normal. Units in the names.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "rt/base/histogram.h"
#include "tools/hil/exchange.h"

namespace tactus::hil {

// Counts every frame that the device numbered and every command, by outcome.
class FrameCounts {
 public:
  void add(const Record& record) noexcept;

  std::uint64_t ticks{0};
  std::uint64_t fresh{0}, corrupt{0}, superseded{0};
  std::uint64_t reordered{0}, duplicated{0};  // whole frames whose number is older than the newest, or equal to it
  std::uint64_t missing_ticks{0}, disconnected_ticks{0};
  std::uint64_t longest_gap_ticks{0};                  // ticks in a row without a whole new frame
  std::uint64_t numbered{0};                           // by the device, from the first frame to the newest
  std::uint64_t commands{0}, refused{0}, answered{0};  // sent; not accepted by the link; echoed by the device

  // Numbered frames that were neither received nor superseded nor broken.
  std::uint64_t lost() const noexcept;
  // Frames that the link counts as received but that are in no record. One or two may be in transit at the start or end
  // of an exchange.
  std::uint64_t unaccounted(const hal::LinkCounters& link) const noexcept;

 private:
  std::uint64_t gap_{0}, superseded_before_first_{0};
  std::uint32_t newest_{0}, newest_echo_{0};
  bool seen_{false};
};

// Round-trip time: from sending a command to the first state frame that acknowledges it. Age of a force: from the
// device's sample to the period in which the resulting effort acts, both by the device's clock.
class RoundTrip {
 public:
  void add(const Record& record) noexcept;
  Histogram round_trip, force_age;

 private:
  struct Command {
    std::uint32_t sequence{0};
    std::int64_t sent_ns{0};
    std::uint64_t sample_us{0};  // device time of the sample that it is based on
  };
  static constexpr std::uint32_t kUnderWay = 256;
  std::array<Command, kUnderWay> commands_{};
  std::uint32_t newest_echo_{0};
  bool seen_{false};
};

// Drift between both clocks, and the device's rate. Compares the shortest delays of the first and the last tenth of the
// frames, so that delayed frames have no effect; needs about a second.
struct ClockFigures {
  double drift_ppm{0};         // rate of the device's clock relative to the host's, minus 1
  double device_period_us{0};  // between numbers, by the device's clock
  double host_period_us{0};    // the same by the host's clock
};
std::optional<ClockFigures> clock_figures(std::span<const Record> records);

// When the device faded or braked, in its own count of missed commands. Frames may be superseded, so there are two
// bounds: after `after`, and at `at` at the latest.
struct Onset {
  std::optional<std::uint32_t> after, at;  // missed commands in a row
  bool is(std::uint32_t frames) const noexcept {
    return at && *at >= frames && (!after || *after < frames) && *at <= frames + 2;
  }
};
struct WatchdogFigures {
  Onset fade, brake;
};
WatchdogFigures watchdog_figures(std::span<const Record> records);

// Device periods from the last frame before `first_sign` to the first one in BRAKE; empty if it never braked.
std::optional<std::uint32_t> frames_to_brake(std::span<const Record> records, std::size_t first_sign);

}  // namespace tactus::hil
