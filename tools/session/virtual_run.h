// A run on a virtual clock: device, loop and global world in one thread, nothing measured, so the same options give the
// same bits. The global world takes the time that a fixed cost table says; a stall adds to it.
// Thread: normal.
#pragma once

#include <functional>

#include "tools/session/session.h"

namespace tactus::session {

// After each tick of a virtual run; returns false to end it. For tests and for progress.
using TickObserver = std::function<bool(const loop::TickOutput&)>;

// The error is the tape's. `observer` may be empty.
Result<RunSummary> run_virtual(Session& session, std::uint64_t ticks, const TickObserver& observer = {});

}  // namespace tactus::session
