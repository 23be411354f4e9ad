// The board's mechanics as registers: encoder counters, motor set-points, the lines of e-stop and supply.
//
// On a chip these are timer counters, PWM compare values and pins; a port replaces the struct by them. On mps2-an386 it
// is memory at an address from the linker script; the process that shares this memory simulates the mechanics. All
// zeros (nothing connected) mean e-stop active and no supply. Thread: the control period's, and the fault handlers.
// Units: counts; set-points in 1/32767 of the full effort; K/1000.
#pragma once

#include <cstddef>
#include <cstdint>

namespace tactus::firmware::cortex_m {

enum class MotorStage : std::uint32_t {
  kOff = 0,      // no current: the axis moves freely
  kDriven = 1,   // the set-points are applied
  kShorted = 2,  // windings shorted: the brake
};

// Signed values are two's complement.
struct BoardRegisters {
  // In, by axis.
  std::uint32_t volatile encoder_count[6];    // wraps
  std::uint32_t volatile index_pulses[6];     // index pulses so far, wraps
  std::uint32_t volatile index_count[6];      // the count that the newest pulse latched
  std::uint32_t volatile winding_rise_mK[6];  // over ambient, from a sensor; 0 without one
  // In: bits.
  std::uint32_t volatile encoder_errors;  // bit k: axis k had a line fault or an impossible transition
  std::uint32_t volatile pins;            // see below
  // Out.
  std::uint32_t volatile motor_stage;          // MotorStage
  std::uint32_t volatile motor_setpoint[6];    // by axis, -32767 to 32767
  std::uint32_t volatile heartbeat;            // toggles once per control period, for an external watchdog
  std::uint32_t volatile fault_program_count;  // program counter at the last processor fault; 0: no fault
};
static_assert(sizeof(BoardRegisters) == 140 && offsetof(BoardRegisters, motor_stage) == 104);

inline constexpr std::uint32_t kPinStopReleased = 1u << 0;  // the e-stop's contact is closed; it opens to stop
inline constexpr std::uint32_t kPinSupplyGood = 1u << 1;
inline constexpr unsigned kFirstButtonPin = 8;  // eight of them
inline constexpr std::int32_t kFullSetpoint = 32767;
inline constexpr std::uint32_t kUnknownPlace = 0xffffffffu;  // fault_program_count if the stack was not readable

// From any context, also with a corrupt stack: plain stores. The stage first, because it alone stops the motors.
inline void short_motors(BoardRegisters& registers) noexcept {
  registers.motor_stage = static_cast<std::uint32_t>(MotorStage::kShorted);
  for (std::uint32_t volatile& setpoint : registers.motor_setpoint) setpoint = 0;
}

}  // namespace tactus::firmware::cortex_m
