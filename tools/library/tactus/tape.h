/// \file
/// Tapes: what Session::record and `tactus run --record` write.
///
/// Thread: any normal one. Bound: memory for one keyframe; time, about that of the run in virtual time.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "tactus/error.h"
#include "tactus/types.h"

namespace tactus {

/// What came of running a tape again.
struct Replay {
  std::uint64_t ticks{0};        ///< on the tape
  std::uint64_t compared{0};     ///< of them run again and compared
  std::uint64_t different{0};    ///< of those with another output
  std::uint64_t lost_ticks{0};   ///< that damage has taken, as far as it can be told
  bool same_bits{false};         ///< all that could be compared is the same, and that is not nothing
  std::string first_difference;  ///< which value, what the tape has and what the replay has; empty: none
  std::string damage;            ///< the first of it in one line; empty: none
  std::string warning;           ///< such as: made with another instruction set; empty: none
};

/// Runs a tape's haptic loop again on the inputs that the tape holds, and compares every output bit by bit.
/// \param tape the file
/// \param replay what came of it
/// \param progress is told the share done, 0 to 1, by the calling thread; may be empty
/// \return kFile where it cannot be replayed at all; a difference or a damage is no error
Error replay_tape(const std::filesystem::path& tape, Replay& replay, const std::function<void(double)>& progress = {});

}  // namespace tactus
