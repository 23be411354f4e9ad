// Timing in the experiments: CPU time of one thread that stays on one core. Thread: one.
#pragma once

namespace tactus::experiment {

// CPU time of this thread [us]; time taken by other programs is not included.
double thread_time_us() noexcept;

// Monotonic wall time [us], for work shared by several threads.
double wall_time_us() noexcept;

// Pins this thread to its current core and flushes denormals, for all engines equally.
void settle_on_core() noexcept;

}  // namespace tactus::experiment
