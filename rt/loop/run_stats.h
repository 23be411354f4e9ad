// Statistics of a run for its summary, accumulated tick by tick on the haptic thread and read after it. Thread: add()
// [rt]; reading: the owner, after the thread has ended. Units in the names. Bound: constant time.
#pragma once

#include "rt/base/histogram.h"
#include "rt/loop/haptic_loop.h"

namespace tactus::loop {

// Cause of a tick that missed its deadline.
enum class OverrunCause : std::uint32_t { kLateWake = 0, kOwnWork = 1, kInterrupted = 2 };

// kOwnWork: the thread used more processor time than the period, and the calibrated cost model explains at least half
// of it by the tick's counts. (A host that takes the core away unnoticed also appears as processor time, but without
// matching counts.) kLateWake: the wake-up was late by more than half of the period, or its lateness and the tick's
// need (processor time, at most twice the prediction) together exceed the period. kInterrupted: otherwise.
// `used_ns`: by the thread's own clock in this tick; `predicted_ns`: by the cost model, before it.
OverrunCause classify_overrun(double wake_late_ns, double used_ns, double predicted_ns, double period_ns) noexcept;

struct FaultEvent {
  std::uint64_t tick{0};
  Fault fault{Fault::kNone};
  std::uint32_t cleared{0};  // 1: a re-arm cleared it in this tick
  // The device's own report at that time, see DeviceSample.
  haptics::DeviceState device_state{haptics::DeviceState::kReset};
  std::uint32_t device_fault{0}, device_limits{0};
};

// Predicted and measured times of the ticks.
struct CostPredictionStats {
  Histogram predicted_ns, measured_permille;  // measured / predicted
  std::uint64_t above{0};                     // ticks that took longer than predicted

  void add(double predicted, double measured) noexcept;  // ns
};

struct RunStats {
  std::uint64_t ticks{0};
  std::uint64_t contact_ticks{0}, armed_ticks{0};
  std::uint64_t status_ticks[32]{};  // ticks in which the StatusBit of this position was set
  std::uint32_t members_max{0}, border_max{0}, contacts_max{0}, points_max{0}, pairs_max{0}, component_max{0};
  std::uint32_t capacity_bits{0};
  std::uint64_t dropped{0};
  std::uint64_t cycles{0}, late_cycles{0}, cycle_ticks_max{0};
  double force_max_N{0}, torque_max_Nm{0}, force_sum_N{0}, force_step_max_N{0};
  double deepest_m{0};
  double deepest_share{0};  // overlap / thickness of the thinner body
  double device_energy_J{0}, damped_energy_J{0}, border_work_J{0}, corrected_J{0}, border_tank_J{0};
  std::uint64_t sub_steps_sum{0};
  std::uint64_t restrained_cycles{0};  // cycles in which the governor allowed fewer members than configured
  FixedVector<FaultEvent, 16> faults;  // re-arms included; of more than 16 the first 15 and the newest
  std::uint64_t fault_count{0};        // latched faults, without re-arms
  std::uint64_t fault_events_dropped{0};
  Fault fault_now{Fault::kNone};  // latched in the last tick

  // `device`: the newest sample. `cycle_ticks`: at a synchronisation, the length of the cycle that it ended; else 0.
  void add(const TickOutput& out, std::uint32_t sub_steps, std::uint32_t component, std::uint32_t cycle_ticks,
           std::uint32_t ratio, const haptics::DeviceSample& device = {}) noexcept;

 private:
  Vec3d last_force_;
};

}  // namespace tactus::loop
