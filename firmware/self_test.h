// Continuous self-test against corrupted memory, one row of the register table per period.
//
// A pass compares the register table in memory with its hash from compile time, and each active value with the
// accepted one (two copies, so that a bit flip in one is detected); checks that the watchdog's effort fractions fall
// from 1 to 0 and that the state table still gives its safe transitions; and records whether encoders or motor supply
// failed meanwhile. If one of the first three checks fails, that is a fault until a whole pass succeeds. The first pass
// runs at construction, before any period. Thread: [rt], the control period's; one row per call. Bound: a pass takes
// one period per row of the table, plus one.
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
  kStoredConfiguration = 1u << 5,  // the saved configuration could not be read at start-up: the factory's is active
};

class SelfTest {
 public:
  explicit SelfTest(std::span<const Register> table = all_registers()) noexcept : table_(table) {}

  // Restarts the pass.
  void start() noexcept {
    row_ = 0;
    so_far_ = 0;
    found_ = 0;
  }

  // `accepted`: the configuration as written; `in_force`: the modules' active copies.
  void step(const ConfigView& accepted, const ConfigView& in_force, bool encoders_good, bool motor_bus_good) noexcept;

  std::uint32_t failed() const noexcept { return failed_; }  // bits of the last whole pass
  std::uint32_t passes() const noexcept { return passes_; }  // whole passes since the start, wraps
  // A check that forbids force has failed in the last pass or, so far, in this one.
  bool is_fault() const noexcept;
  std::uint32_t periods_per_pass() const noexcept { return static_cast<std::uint32_t>(table_.size()) + 1; }

 private:
  void note(SelfTestBit bit) noexcept { found_ |= static_cast<std::uint32_t>(bit); }

  std::span<const Register> table_;
  std::size_t row_{0};
  std::uint32_t so_far_{0}, found_{0}, failed_{0}, passes_{0};
};

// The watchdog's effort fractions for this configuration fall from 1 to 0, and a stop leads from every state to BRAKE.
bool is_watchdog_good(const Config& config) noexcept;

}  // namespace tactus::firmware
