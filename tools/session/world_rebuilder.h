// Steps the global world of a taped run again, on the reports that the replay of the haptic loop gives, and compares
// every snapshot with the taped one, byte by byte.
//
// A tape holds the haptic side alone; the world outside of the sub-world follows from it, because the global world
// depends on its scene, its options and the reports. In turn with a TapePlayer: take_snapshot() before the tick that
// adopts it, adopted() after that tick.
// Thread: one, normal, with denormals flushed. Bound: one global step a snapshot.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tools/session/tape_player.h"

namespace tactus::session {

// Why the world of this tape cannot be rebuilt, as far as its header says; empty: it can.
std::string why_not_rebuilt(const OpenTape& tape);

class WorldRebuilder {
 public:
  // `world`: at its start, of the tape's scene and options; it must outlive this object.
  explicit WorldRebuilder(sim::GlobalWorld& world);

  // Steps the world to this snapshot. Error: the taped snapshot is another one, or one before it is missing; the world
  // is of no use from then on.
  Status take_snapshot(const loop::TapeRecord& record);
  // The tick that adopted the snapshot was played: its report, and the members that the governor then allowed. Error:
  // the tape does not say how many.
  Status adopted(const haptics::SubWorldReport& report, std::uint32_t member_budget);

  const sim::GlobalWorld& world() const noexcept { return world_; }  // as it was when the newest snapshot was made
  std::uint64_t snapshots() const noexcept { return snapshots_; }    // that equalled the taped ones

 private:
  sim::GlobalWorld& world_;
  std::unique_ptr<haptics::WorldSnapshot> next_;
  std::unique_ptr<haptics::SubWorldReport> report_;
  bool has_report_{false};
  std::uint64_t snapshots_{0};
  std::vector<std::byte> bytes_;
};

}  // namespace tactus::session
