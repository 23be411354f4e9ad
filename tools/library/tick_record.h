// A tick of the loop as the public header has it. Thread: [rt]. Bound: constant time, no allocation.
#pragma once

#include "tactus/tick.h"
#include "tools/session/session.h"

namespace tactus::library {

Tick to_tick(const session::Driver& driver, double period_s) noexcept;

}  // namespace tactus::library
