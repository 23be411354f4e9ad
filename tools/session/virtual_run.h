// A run on a virtual clock: device, loop and global world in one thread, nothing measured, so the same options give the
// same bits. The global world takes the time that a fixed cost table says; a stall adds to it.
// Thread: normal.
#pragma once

#include <functional>

#include "tools/session/session.h"

namespace tactus::session {

// After each tick of a virtual run; returns false to end it. For tests and for progress.
using TickObserver = std::function<bool(const loop::TickOutput&)>;

// What the cost table says a global step took, by its counts [ns], searching for contacts included.
double global_step_ns(const sim::GlobalStatistics& last, std::uint32_t sub_steps) noexcept;

// The error is that of the threads that share the global world's steps. `observer` may be empty.
Result<RunSummary> run_virtual(Session& session, std::uint64_t ticks, const TickObserver& observer = {});

}  // namespace tactus::session
