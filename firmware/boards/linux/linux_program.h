// What the programs of all Linux boards share: their arguments, the real-time set-up, and the pace of the control
// period.
//
// A board's main() parses, opens its mechanics and its link, and calls run_board(). Errors are one line that says what
// to do; an empty string is none. Thread: parse_arguments, make_realtime, stop_on_signals [setup]; run_paced and
// run_board on the control thread, [rt] from their first period: absolute deadlines of CLOCK_MONOTONIC, and a period
// that comes too late is skipped and counted, never made up for in a burst.
#pragma once

#include <atomic>
#include <cstdint>
#include <cstdio>
#include <span>
#include <string>

#include "firmware/board.h"

namespace tactus::firmware {

struct ProgramOptions {
  std::string mechanics;          // --mechanics: see mechanics_file.h
  std::string state;              // --state: where the configuration is kept; empty: nowhere
  std::uint32_t period_us{1000};  // --period-us, 50 to 1 000 000
  int priority{80};               // --priority, SCHED_FIFO 1 to 99; 0: a normal thread
  int cpu{-1};                    // --cpu; -1: any
  std::uint64_t periods{0};       // --periods: ends after so many; 0: on SIGINT or SIGTERM
};

// An option of one kind of board: --name VALUE.
struct BoardOption {
  const char* name;     // without the dashes
  const char* value;    // what the value is, in capitals
  const char* meaning;  // for --help
  std::string* target;
};

struct ParsedArguments {
  bool run{false};  // false: print `text` and end with `status`
  int status{0};    // 0: help was asked for; 2: bad arguments
  std::string text;
};

ParsedArguments parse_arguments(int argc, const char* const* argv, const char* purpose,
                                std::span<const BoardOption> board_options, ProgramOptions& options);

// Makes the calling thread a real-time one: memory locked, on its core, SCHED_FIFO. What was refused, each with its
// cure, in one line; empty: all granted. The board runs all the same.
std::string make_realtime(int priority, int cpu);

// SIGINT and SIGTERM set it.
const std::atomic<bool>& stop_on_signals();

struct PaceCounters {
  std::uint64_t periods{0};     // that ran
  std::uint64_t skipped{0};     // deadlines that passed while a period ran or the thread did not wake
  std::int64_t max_late_ns{0};  // the latest wake-up
};

// CLOCK_MONOTONIC.
std::int64_t now_ns() noexcept;

// The sleep of one period after another. Bound of a wait: one period.
class Pace {
 public:
  explicit Pace(std::uint32_t period_us) noexcept;
  void wait() noexcept;  // to the next deadline
  const PaceCounters& counters() const noexcept { return counters_; }

 private:
  std::int64_t period_ns_, deadline_ns_;
  PaceCounters counters_;
};

// Calls `period` until `stop`, or `periods` times if that is not 0.
template <class Period>
PaceCounters run_paced(std::uint32_t period_us, std::uint64_t periods, const std::atomic<bool>& stop,
                       Period&& period) noexcept {
  Pace pace(period_us);
  while (!stop.load(std::memory_order_relaxed) && (periods == 0 || pace.counters().periods < periods)) {
    pace.wait();
    period();
  }
  return pace.counters();
}

// The control loop of a board whose device, mechanics, link and storage are ready. At the end the motors are shorted.
template <Mechanics M, DeviceLink L, Storage S>
PaceCounters run_board(const ProgramOptions& options, const std::atomic<bool>& stop, Device& device, M& mechanics,
                       L& link, S& storage) {
  if (const std::string refused = make_realtime(options.priority, options.cpu); !refused.empty())
    std::fprintf(stderr, "not real-time: %s\n", refused.c_str());
  const PaceCounters counters = run_paced(options.period_us, options.periods, stop,
                                          [&]() noexcept { run_period(device, mechanics, link, storage); });
  mechanics.drive(ControllerOutputs{});
  return counters;
}

template <Mechanics M, DeviceLink L>
PaceCounters run_board(const ProgramOptions& options, const std::atomic<bool>& stop, Device& device, M& mechanics,
                       L& link) {
  NoStorage none;
  return run_board(options, stop, device, mechanics, link, none);
}

}  // namespace tactus::firmware
