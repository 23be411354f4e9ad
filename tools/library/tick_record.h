// Converts a tick of the loop to the public Tick. Thread: [rt]. Bound: constant time, no allocation.
#pragma once

#include "tactus/tick.h"
#include "tools/session/session.h"

namespace tactus::library {

Tick to_tick(const session::Driver& driver, double period_s) noexcept;

}  // namespace tactus::library
