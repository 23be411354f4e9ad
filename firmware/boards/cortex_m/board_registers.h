// The board's mechanics as registers: encoder counters, motor set-points, the lines of e-stop and supply.
//
// On a chip these are the counters of its timers, the compare values of its PWM, its pins: a port replaces the struct
// by them. On mps2-an386 it is memory at an address that the linker script gives, and whoever shares that memory is the
// mechanics. Read so that a board where nothing is connected (all zeros) is stopped and without supply.
// Thread: the control period's, and the fault handlers. Units: counts; set-points in 1/32767 of the full effort.
#pragma once

#include <cstddef>
#include <cstdint>

namespace tactus::firmware::cortex_m {

enum class MotorStage : std::uint32_t {
  kOff = 0,      // no current: the axis moves freely
  kDriven = 1,   // the set-points act
  kShorted = 2,  // windings shorted: the brake
};

struct BoardRegisters {
  std::uint32_t volatile encoder_count[6];     // in: two's complement, wraps
  std::uint32_t volatile pins;                 // in: see below
  std::uint32_t volatile motor_stage;          // out: MotorStage
  std::uint32_t volatile motor_setpoint[6];    // out: -32767 to 32767, two's complement
  std::uint32_t volatile heartbeat;            // out: toggles once per control period, for an external watchdog
  std::uint32_t volatile fault_program_count;  // out: where the program was when it failed, 0 if it did not
};
static_assert(sizeof(BoardRegisters) == 64 && offsetof(BoardRegisters, motor_stage) == 28);

inline constexpr std::uint32_t kPinStopReleased = 1u << 0;  // the e-stop's contact is closed: it opens to stop
inline constexpr std::uint32_t kPinSupplyGood = 1u << 1;
inline constexpr unsigned kFirstButtonPin = 8;  // eight of them
inline constexpr std::int32_t kFullSetpoint = 32767;

// From any context, also with a broken stack: plain stores. The stage first, since that alone stops the motors.
inline void short_motors(BoardRegisters& registers) noexcept {
  registers.motor_stage = static_cast<std::uint32_t>(MotorStage::kShorted);
  for (std::uint32_t volatile& setpoint : registers.motor_setpoint) setpoint = 0;
}

}  // namespace tactus::firmware::cortex_m
