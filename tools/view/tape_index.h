// Reads a tape once, for its length, the places of its keyframes, and its damage.
//
// Thread: one, normal. Bound: 24 bytes for each keyframe, of which there is one a second.
#pragma once

#include <string>
#include <vector>

#include "tools/session/running_summary.h"
#include "tools/session/tape_player.h"

namespace tactus::view {

struct TapeIndex {
  struct Keyframe {
    std::uint64_t tick{0};  // tick after the keyframe
    std::uint64_t offset{0}, index{0};
  };
  struct FaultMark {
    std::uint64_t tick{0};  // in which it latched
    Fault fault{Fault::kNone};
  };
  std::vector<Keyframe> keyframes;
  std::vector<FaultMark> faults;  // the first kMaxFaults
  std::uint64_t first_tick{0}, last_tick{0}, ticks{0};
  std::uint64_t gaps{0}, damages{0};
  std::string damage;     // the first, in one line
  bool has_times{false};  // records of stage times follow the ticks

  // The last keyframe at or before a tick; the first one, if all are later.
  std::size_t keyframe_before(std::uint64_t tick) const noexcept;
};
inline constexpr std::size_t kMaxFaults = 64;

// `counts`: takes every tick, for the tape's verdict; may be null. Error, one line with the path: no tick, or no
// keyframe; damage is not an error.
Result<TapeIndex> index_of(session::OpenTape& tape, session::RunningSummary* counts = nullptr);

}  // namespace tactus::view
