// Tests on records, per phase, shared by several checks: was FORCE reached, was BRAKE kept.
// Thread: normal.
#pragma once

#include <span>
#include <string>

#include "firmware/faults.h"
#include "tools/hil/exchange.h"

namespace tactus::hil {

// The records of phases `first` to `last`. Phases are in order in the records.
std::span<const Record> in_phases(std::span<const Record> records, std::uint32_t first, std::uint32_t last);

// Empty if the device was in FORCE at the phase's end; otherwise the reason, as text.
std::string never_forced(std::span<const Record> records, std::uint32_t phase);

// Empty if every frame of the phase's second half reports BRAKE with this fault; otherwise the observed state.
std::string latch_broken(std::span<const Record> records, std::uint32_t phase, firmware::Fault fault);

}  // namespace tactus::hil
