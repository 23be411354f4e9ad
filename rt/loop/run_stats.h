// What a run amounts to, gathered tick by tick on the haptic thread and read after it: the figures of the summary.
// Thread: add() [rt]; reading: the owner, after the thread has ended. Units in the names. Bound: constant time.
#pragma once

#include "rt/base/histogram.h"
#include "rt/loop/haptic_loop.h"

namespace tactus::loop {

// Why a tick was past its deadline.
enum class OverrunCause : std::uint32_t { kLateWake = 0, kOwnWork = 1, kInterrupted = 2 };

// A tick that missed its deadline is the program's own doing when its work, as the calibrated cost model predicts it
// from the counts, does not fit the period by itself, or when it is the third miss in a row of ticks that woke in time:
// a gap of the machine hits one tick, work that is too much hits them all. It is a late wake-up when the wake-up took
// more than half of the period, or just what the work needed. Otherwise it was interrupted: the machine's gap.
// `missed_before`: ticks in a row before this one that missed their deadlines as well.
OverrunCause classify_overrun(double wake_late_ns, double predicted_ns, double period_ns,
                              std::uint32_t missed_before) noexcept;

struct FaultEvent {
  std::uint64_t tick{0};
  Fault fault{Fault::kNone};
  std::uint32_t cleared{0};  // 1: a re-arm took it back at this tick
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
  double device_energy_J{0}, damped_energy_J{0}, border_work_J{0};
  std::uint64_t sub_steps_sum{0};
  FixedVector<FaultEvent, 16> faults;  // the first 16
  std::uint64_t fault_count{0};

  // `cycle_ticks`: where a synchronisation happened, the length of the cycle that it ended; else 0.
  void add(const TickOutput& out, std::uint32_t sub_steps, std::uint32_t component, std::uint32_t cycle_ticks,
           std::uint32_t ratio) noexcept;

 private:
  Vec3d last_force_;
  Fault last_fault_{Fault::kNone};
};

}  // namespace tactus::loop
