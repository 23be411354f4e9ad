// How the experiments time: the CPU time of one thread that stays on one core. Thread: one.
#pragma once

#include <vector>

namespace tactus::experiment {

// Time that this thread computed [us]: what other programs took of the core does not count.
double thread_time_us() noexcept;

// Time that passed [us], on a clock that never goes back: for work that several threads share.
double wall_time_us() noexcept;

// Where this process may run, ascending.
std::vector<int> allowed_cores();

// Keeps this thread on the core where it is, with denormals flushed for every engine alike.
void settle_on_core() noexcept;

}  // namespace tactus::experiment
