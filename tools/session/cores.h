// The cores on which this program may keep a thread. Thread: any normal one; nothing here changes an affinity.
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "rt/base/result.h"

namespace tactus::session {

// The cores that this process may use, without `spare_cpu` unless it is the only one.
std::vector<int> cores_without(int spare_cpu);

// The core of a hand's haptic thread: `cpu`, or where that is -1 the last one that this process may use for hand 0, and
// for the next hand the one before it; -1: unknown.
int core_of_hand(int cpu, std::size_t hand = 0);

// Checks that a thread may stay on this core: it is online and in the process' cpuset. -1, no choice, is good. An error
// is one line that begins with the option's name.
Status check_core(std::string_view option, int cpu);

}  // namespace tactus::session
