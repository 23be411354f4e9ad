// Shared parts of the Linux boards' programs: arguments, real-time set-up, and timing of the control period.
//
// A board's main() parses, opens its mechanics and its link, and calls run_board(). Errors are one line that says what
// to do; an empty string means no error. Thread: parse_arguments, make_realtime, stop_on_signals [setup]; run_paced and
// run_board on the control thread, [rt] from their first period: absolute deadlines of CLOCK_MONOTONIC; missed periods
// are skipped and counted, not caught up in a burst.
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
  std::string state;              // --state: file of the saved configuration; empty: none
  std::uint32_t period_us{1000};  // --period-us, 50 to 1 000 000
  int priority{80};               // --priority, SCHED_FIFO 1 to 99; 0: a normal thread
  int cpu{-1};                    // --cpu; -1: any
  std::uint64_t periods{0};       // --periods: number of periods to run; 0: until SIGINT or SIGTERM
};

// An option that only one kind of board has: --name VALUE.
struct BoardOption {
  const char* name;     // without the dashes
  const char* value;    // placeholder of the value for --help, in capitals
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

// Makes the calling thread real-time: memory locked, pinned to its core, SCHED_FIFO. Returns in one line what was
// refused and how to remedy it; empty: nothing. The board runs in either case.
std::string make_realtime(int priority, int cpu);

// Installs handlers; SIGINT and SIGTERM set the returned flag.
const std::atomic<bool>& stop_on_signals();

struct PaceCounters {
  std::uint64_t periods{0};     // executed periods
  std::uint64_t skipped{0};     // deadlines missed during an overlong period or a late wake-up
  std::int64_t max_late_ns{0};  // largest wake-up latency
};

// CLOCK_MONOTONIC.
std::int64_t now_ns() noexcept;

// Sleeps until the deadline of each period. Bound of a wait: one period.
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
