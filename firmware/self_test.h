// Is the device still what it was built to be? Looked at all the time, a row of the register table per period.
//
// A pass compares the register table in memory with the fingerprint that the compiler made of it, and each value in
// force with the one that was accepted (two copies, so that a bit that flipped in one shows); checks that the
// watchdog's shares fall from 1 to 0 and that the state table keeps its safe answers; and notes whether encoders or
// motor supply failed meanwhile. A failed check of the first three is a fault until a whole pass is good again. The
// first pass runs at construction, before any period. Thread: [rt], the control period's; one row per call. Bound: a
// pass takes as many periods as the table has rows, and one.
#pragma once

#include "firmware/registers.h"

namespace tactus::firmware {

// Bits of the register self_test_failed; never reused.
enum class SelfTestBit : std::uint32_t {
  kTables = 1u << 0,
  kConfiguration = 1u << 1,
  kWatchdog = 1u << 2,
  kEncoders = 1u << 3,
  kMotorBus = 1u << 4,
  kStoredConfiguration = 1u << 5,  // a saved one was there at the start and could not be read: factory's in force
};

class SelfTest {
 public:
  explicit SelfTest(std::span<const Register> table = all_registers()) noexcept : table_(table) {}

  // Begins a pass anew.
  void start() noexcept { row_ = 0, so_far_ = 0, found_ = 0; }

  // `accepted`: what was written; `in_force`: what the rooms hold.
  void step(const ConfigView& accepted, const ConfigView& in_force, bool encoders_good, bool motor_bus_good) noexcept;

  std::uint32_t failed() const noexcept { return failed_; }  // bits of the last whole pass
  std::uint32_t passes() const noexcept { return passes_; }  // whole passes since the start, wraps
  // A check that forbids force has failed, in the last pass or so far in this one.
  bool is_fault() const noexcept;
  std::uint32_t periods_per_pass() const noexcept { return static_cast<std::uint32_t>(table_.size()) + 1; }

 private:
  void note(SelfTestBit bit) noexcept { found_ |= static_cast<std::uint32_t>(bit); }

  std::span<const Register> table_;
  std::size_t row_{0};
  std::uint32_t so_far_{0}, found_{0}, failed_{0}, passes_{0};
};

// The watchdog's shares for this configuration fall from 1 to 0, and no state answers a stop with anything but BRAKE.
bool is_watchdog_good(const Config& config) noexcept;

}  // namespace tactus::firmware
