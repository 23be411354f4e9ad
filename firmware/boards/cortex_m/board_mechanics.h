// Encoders and motors behind the board's registers: the Mechanics of firmware/board.h.
//
// Thread: the control period's, [rt]. Units: input N or N m per axis, output set-points in 1/32767 of the axis's full
// effort. Bound: set-points saturate at the full one; an axis whose full effort is 0 has no motor and gets 0. Of
// several index pulses within one period only the newest is reported.
#pragma once

#include "firmware/board.h"
#include "firmware/boards/cortex_m/board_registers.h"
#include "firmware/boards/cortex_m/period_clock.h"

namespace tactus::firmware::cortex_m {

class BoardMechanics {
 public:
  // `full_effort`: N or N m per motor at the full set-point.
  BoardMechanics(BoardRegisters& registers, const PeriodClock& clock, const AxisValues& full_effort) noexcept
      : registers_(registers), clock_(clock) {
    for (unsigned i = 0; i < kAxes; ++i) {
      setpoint_per_effort_[i] = full_effort[i] > 0.0f ? static_cast<float>(kFullSetpoint) / full_effort[i] : 0.0f;
      index_pulses_[i] = registers.index_pulses[i];
    }
  }

  void sample(ControllerInputs& inputs) noexcept {
    const std::uint32_t pins = registers_.pins;
    inputs.time_us = clock_.now_us();
    inputs.buttons = static_cast<std::uint8_t>(pins >> kFirstButtonPin);
    inputs.emergency_stop = (pins & kPinStopReleased) == 0;
    inputs.motor_bus_ok = (pins & kPinSupplyGood) != 0;
    inputs.encoder_errors = static_cast<std::uint8_t>(registers_.encoder_errors & ((1u << kAxes) - 1u));
    inputs.index_edges = 0;
    for (unsigned i = 0; i < kAxes; ++i) {
      inputs.counts[i] = static_cast<std::int32_t>(registers_.encoder_count[i]);
      inputs.measured_rise_K[i] = static_cast<float>(static_cast<std::int32_t>(registers_.winding_rise_mK[i])) * 1e-3f;
      // Read the pulse counter before the latched count: a pulse between the two reads is reported again, with the same
      // count, in the next period.
      const std::uint32_t pulses = registers_.index_pulses[i];
      if (pulses != index_pulses_[i]) inputs.index_edges = static_cast<std::uint8_t>(inputs.index_edges | 1u << i);
      index_pulses_[i] = pulses;
      inputs.index_counts[i] = static_cast<std::int32_t>(registers_.index_count[i]);
    }
  }

  void drive(const ControllerOutputs& outputs) noexcept {
    if (outputs.brake) {
      short_motors(registers_);
    } else {
      bool any = false;
      for (unsigned i = 0; i < kAxes; ++i) {
        const std::int32_t setpoint = setpoint_of(outputs.effort[i] * setpoint_per_effort_[i]);
        registers_.motor_setpoint[i] = static_cast<std::uint32_t>(setpoint);
        any = any || setpoint != 0;
      }
      registers_.motor_stage = static_cast<std::uint32_t>(any ? MotorStage::kDriven : MotorStage::kOff);
    }
    registers_.heartbeat = registers_.heartbeat ^ 1u;
  }

 private:
  // Rounds to the nearest; NaN gives 0.
  static std::int32_t setpoint_of(float x) noexcept {
    constexpr auto full = static_cast<float>(kFullSetpoint);
    if (!(x > -full)) return x == x ? -kFullSetpoint : 0;
    if (x >= full) return kFullSetpoint;
    return static_cast<std::int32_t>(x < 0.0f ? x - 0.5f : x + 0.5f);
  }

  BoardRegisters& registers_;
  const PeriodClock& clock_;
  AxisValues setpoint_per_effort_{};
  std::array<std::uint32_t, kAxes> index_pulses_{};
};
static_assert(Mechanics<BoardMechanics>);

}  // namespace tactus::firmware::cortex_m
