// The status line of a run, on standard error: on a terminal each line overwrites the one before.
// Thread: main.
#pragma once

#include <cstdint>
#include <span>

#include "tools/session/realtime_run.h"

namespace tactus::tools {

// `last_ticks`, `last_s`: of the call before, for the rate.
void show_live(const session::LiveStatus& live, double elapsed_s, bool terminal, std::uint64_t& last_ticks,
               double& last_s);
// Of several hands.
void show_live(std::span<const session::LiveStatus* const> hands, double elapsed_s, bool terminal);

}  // namespace tactus::tools
