// Replays a tape: the same loop with the same inputs; every output is compared bit by bit.
// Thread: normal.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "rt/base/result.h"

namespace tactus::session {

struct ReplayReport {
  std::uint64_t ticks{0}, compared{0};  // on the tape; replayed and compared
  std::uint64_t keyframes{0}, snapshots{0}, gaps{0};
  std::uint64_t different{0};  // ticks whose output differs
  std::uint64_t first_different_tick{0};
  std::string first_difference;          // the field, its value on the tape, its replayed value
  std::uint64_t keyframes_different{0};  // keyframes that the replay's own state did not reproduce
  std::uint64_t unreplayable{0};         // ticks between a gap or damage and the next keyframe
  std::uint64_t damages{0};              // places where records could not be read
  std::uint64_t lost_bytes{0};           // there
  std::uint64_t lost_ticks{0};           // ticks there, from the tick numbers; unknown after the last readable tick
  std::string damage;                    // the first damage, in one line
  std::string scene_name, scene_file, scene_hash;
  std::string made_by;  // the program that wrote the tape; empty: not recorded
  std::string warning;  // the tape was made with another instruction set
  std::uint64_t state_hash{0};

  // At least one tick was compared, and everything compared is bit-identical.
  bool same_bits() const noexcept { return different == 0 && keyframes_different == 0 && compared > 0; }
  bool good() const noexcept { return same_bits() && damages == 0; }
};

// Error, one line: the tape cannot be replayed at all. `progress` receives the completed fraction, 0 to 1.
Result<ReplayReport> replay(const std::string& path, const std::function<void(double)>& progress = {});

}  // namespace tactus::session
