// What records say: which frames came, how long a command takes to be answered, how old the force is, how the two
// clocks go. Everything from the records alone, so that a soak of any length is read as it comes. Thread: normal. Units
// in the names.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "rt/base/histogram.h"
#include "tools/hil/exchange.h"

namespace tactus::hil {

// Every frame that the device numbered, by what became of it, and what the commands did.
class FrameBook {
 public:
  void add(const Record& record) noexcept;

  std::uint64_t ticks{0};
  std::uint64_t fresh{0}, corrupt{0}, superseded{0};
  std::uint64_t reordered{0}, duplicated{0};  // whole frames whose number is older than, or that of, the newest
  std::uint64_t missing_ticks{0}, disconnected_ticks{0};
  std::uint64_t longest_gap_ticks{0};                  // ticks in a row without a whole new frame
  std::uint64_t numbered{0};                           // by the device, from the first frame to the newest
  std::uint64_t commands{0}, refused{0}, answered{0};  // sent, not taken on by the link, seen echoed

  // Numbered, and neither came nor was superseded nor broken.
  std::uint64_t lost() const noexcept;
  // Of the frames that the link says it received, those that no record accounts for. What is under way at either end of
  // an exchange may be one or two.
  std::uint64_t unaccounted(const hal::LinkCounters& link) const noexcept;

 private:
  std::uint64_t gap_{0}, superseded_before_first_{0};
  std::uint32_t newest_{0}, newest_echo_{0};
  bool seen_{false};
};

// From a command's sending to the first state frame that says the device has it; and the age of a force: from the
// device's sample to the period in which the effort that answers it acts, both by the device's clock.
class RoundTrip {
 public:
  void add(const Record& record) noexcept;
  Histogram round_trip, force_age;

 private:
  struct Command {
    std::uint32_t sequence{0};
    std::int64_t sent_ns{0};
    std::uint64_t sample_us{0};  // device time of the sample that it answers
  };
  static constexpr std::uint32_t kUnderWay = 256;
  std::array<Command, kUnderWay> commands_{};
  std::uint32_t newest_echo_{0};
  bool seen_{false};
};

// Both clocks against each other, and the device's own rate. The shortest delays of the first and the last tenth of the
// frames are compared, so that what delays frames does not count: needs a second or so.
struct ClockFigures {
  double drift_ppm{0};         // the device's clock gains so much on the host's
  double device_period_us{0};  // between numbers, by the device's clock
  double host_period_us{0};    // the same by the host's clock
};
std::optional<ClockFigures> clock_figures(std::span<const Record> records);

// When, in the device's own count of missed commands, it faded and braked. The bounds bracket what superseded frames
// may have hidden: it happened after `after` and at `at` at the latest.
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

// Device periods from the last frame without the sign to the first one in BRAKE; nothing if it never braked.
std::optional<std::uint32_t> frames_to_brake(std::span<const Record> records, std::size_t first_sign);

}  // namespace tactus::hil
