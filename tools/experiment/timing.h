// How the experiments time: the CPU time of one thread that stays on one core. Thread: one.
#pragma once

namespace tactus::experiment {

// Time that this thread computed [us]: what other programs took of the core does not count.
double thread_time_us() noexcept;

// Keeps this thread on the core where it is, with denormals flushed for every engine alike.
void settle_on_core() noexcept;

}  // namespace tactus::experiment
