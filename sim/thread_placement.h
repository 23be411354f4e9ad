// Where the global world's threads run: normal priority, on the cores asked for. Thread: [setup].
#pragma once

#include <thread>

#include "rt/base/result.h"

namespace tactus::sim {

// A thread inherits its creator's class, which may be real time by now.
Status make_normal(std::thread& thread);

// `cpu` -1: wherever.
Status pin(std::thread& thread, int cpu);

}  // namespace tactus::sim
