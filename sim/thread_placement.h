// Sets priority and core of the global world's threads. Thread: [setup].
#pragma once

#include <thread>

#include "rt/base/result.h"

namespace tactus::sim {

// Sets normal priority: a thread inherits its creator's scheduling class, which may be real time.
Status make_normal(std::thread& thread);

// Pins the thread to a CPU; `cpu` -1: no pinning.
Status pin(std::thread& thread, int cpu);

}  // namespace tactus::sim
