// The host's GPIO lines: the e-stop's status in, drive-enable, oscilloscope probe and watchdog heartbeat out.
//
// The e-stop itself is wired to the device, which cuts the force; this line only informs the host. Only gpio_lines.cpp
// uses libgpiod (version 1; version 2 has a different interface).
// Thread: open(), destruction [setup]; the rest [rt], by one thread. No allocation, no lock, no throw. Bound: estop()
// is one non-blocking read, and one more if the kernel's queue of 16 edges was full; setting a line is one ioctl,
// none if the level does not change. With an on-chip controller these take microseconds. A controller behind I2C or USB
// sleeps: open() tries every line and refuses one that never answers within kMaxCall. Beyond the bounds: an e-stop line
// that cannot be read counts as stop; a failure to set an output is counted. A line that is not in the options does
// nothing. The destructor sets the outputs inactive. If the process dies, the wiring determines their level: give
// drive-enable a resistor to its inactive level.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>

#include "hal/gpio/gpio_options.h"

struct gpiod_line_event;  // of libgpiod

namespace tactus::hal {

struct GpioCounters {
  std::uint64_t estop_edges{0};   // edges read, both directions
  std::uint64_t read_failed{0};   // failed reads of the e-stop
  std::uint64_t write_failed{0};  // failed writes to any output
};

class GpioLines {
 public:
  static constexpr std::chrono::microseconds kMaxCall{500};

  // Errors, one line each: no such chip, no permission, no such line, line in use, a chip that sleeps.
  static Result<std::unique_ptr<GpioLines>> open(const GpioOptions& options);

  ~GpioLines();
  GpioLines(const GpioLines&) = delete;
  GpioLines& operator=(const GpioLines&) = delete;

  // True if the e-stop is active now or was active since the last call, however briefly.
  bool estop() noexcept;
  // In place of estop(), where several threads read it (hand_lines.h): each by any of them at any time.
  bool estop_edge() noexcept;   // it became active since the last call of any thread; or it cannot be read
  bool estop_level() noexcept;  // it is active now, or cannot be read
  void enable(bool on) noexcept;
  void probe(bool active) noexcept;
  void heartbeat() noexcept;  // toggles the line

  GpioCounters counters() const noexcept {
    constexpr auto relaxed = std::memory_order_relaxed;
    return {edges_.load(relaxed), read_failed_.load(relaxed), write_failed_};
  }

 private:
  struct Output {
    void* line{nullptr};  // libgpiod's line; null: not in the options
    bool active{false};
  };

  GpioLines() = default;
  Status request(const GpioOptions& options);
  Status request_estop(const GpioLine& line);
  Status request_output(const GpioLine& line, const char* purpose, Output& output);
  bool read_estop_level() noexcept;
  // The edges since the last read, at most kQueuedEdges, into `edges`; -1 if they cannot be read. Counts them.
  int read_estop_edges(gpiod_line_event* edges) noexcept;
  void count_failed_read() noexcept { read_failed_.fetch_add(1, std::memory_order_relaxed); }
  void set(Output& output, bool active) noexcept;

  void* chip_{nullptr};
  std::string chip_name_;
  void* estop_{nullptr};
  bool estop_active_{false};
  Output enable_, probe_, heartbeat_;
  std::atomic<std::uint64_t> edges_{0}, read_failed_{0};
  std::uint64_t write_failed_{0};
};

}  // namespace tactus::hal
