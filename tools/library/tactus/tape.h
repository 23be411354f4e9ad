/// \file
/// Replay of tapes, which Session::record and `tactus run --record` write.
///
/// Thread: any normal one. Bound: memory for one keyframe; about the time of the run in virtual time.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "tactus/error.h"
#include "tactus/types.h"

namespace tactus {

/// Result of a replay.
struct Replay {
  std::uint64_t ticks{0};        ///< on the tape
  std::uint64_t compared{0};     ///< ticks replayed and compared
  std::uint64_t different{0};    ///< compared ticks whose output differs
  std::uint64_t lost_ticks{0};   ///< ticks lost to damage, as far as this can be determined
  bool same_bits{false};         ///< at least one tick was compared, and everything compared is identical
  std::string first_difference;  ///< value name, value on the tape, replayed value; empty: none
  std::string damage;            ///< the first damage, in one line; empty: none
  std::string warning;           ///< such as a tape made with another instruction set; empty: none
};

/// Runs the haptic loop again on the recorded inputs and compares every output bit by bit.
/// \param tape the file
/// \param replay the result
/// \param progress called by the calling thread with the completed fraction, 0 to 1; may be empty
/// \return kFile: the tape cannot be replayed at all; a difference or damage is not an error
Error replay_tape(const std::filesystem::path& tape, Replay& replay, const std::function<void(double)>& progress = {});

}  // namespace tactus
