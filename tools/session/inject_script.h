// Parses the part of an `--inject` script that does not concern the device.
// `stall@TICK+TICKS`: the global world is late once by that many ticks, from the first report after TICK on.
// `reset@TICK`: the operator resets the scene.
// Thread: normal.
#pragma once

#include <string>
#include <vector>

#include "rt/base/result.h"

namespace tactus::session {

struct WorldStall {
  std::uint64_t at_tick{0};
  std::uint64_t ticks{0};
};

struct InjectScript {
  std::vector<WorldStall> stalls;     // ascending
  std::vector<std::uint64_t> resets;  // ticks, ascending
  std::string device;                 // the rest, for hal::parse_fault_script
};

Result<InjectScript> split_inject_script(const std::string& script);

}  // namespace tactus::session
