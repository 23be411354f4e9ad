// Opens a tape, walks through its records, and runs the haptic loop again on them.
//
// A replay compares the loop's outputs with the tape's (replay.h); an export reads the members' poses from the loop.
// Thread: normal. Bound: one record and one loop in memory, whatever the tape's length.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "rt/loop/flight_recorder.h"
#include "rt/tape/tape.h"
#include "tools/session/session.h"

namespace tactus::session {

struct OpenTape {
  std::string path;
  std::unique_ptr<loop::TapeReader> reader;
  TapeSettings settings;
  std::string warning;  // the tape was made with another instruction set; empty: it was not
};

// Error, one line with the path: no tape, or a header that this program did not write.
Result<OpenTape> open_tape(const std::string& path);

// The session that the tape's header describes, never started: its scene, and the loop for a TapePlayer. Of one hand of
// several it has no global world. Error, one line with the path.
Result<std::unique_ptr<Session>> session_of(const OpenTape& tape);

using OnDamage = std::function<void(const std::string& what, std::uint64_t lost_bytes)>;

// Reads the next undamaged record, and calls `damage` for damaged bytes before it. False: the tape ends.
bool next_record(OpenTape& tape, loop::TapeRecord& record, const OnDamage& damage);

struct TapeVisitor {
  std::function<Status(const loop::TapeRecord& record)> record;  // an error ends the walk
  // Records are missing from here on: what is damaged, and how many bytes were skipped to the next readable record.
  OnDamage damage;
  std::function<void(double share)> progress;  // read so far, 0 to 1; may be empty
};

// From the tape's first record to its last. Returns the visitor's error, with the path before it.
Status walk(OpenTape& tape, const TapeVisitor& visitor);

// Error: the record is no tick. The bytes are copied: a record in the file is not aligned.
Result<loop::TickRecord> tick_of(const loop::TapeRecord& record);
Result<loop::TickTimesRecord> times_of(const loop::TapeRecord& record);

class TapePlayer {
 public:
  explicit TapePlayer(std::unique_ptr<loop::HapticLoop> loop);

  // Restores the loop from a keyframe, which is also what a replay continues from after a gap. `same`: whether the
  // loop's own state equalled it, or the loop had none to compare. Error: no keyframe of this scene.
  Status take_keyframe(const loop::TapeRecord& record, bool& same);
  // Keeps the snapshot for the tick that adopts it. Error: no snapshot.
  Status take_snapshot(const loop::TapeRecord& record);
  // Runs the tick; false if it cannot be: no keyframe since the start, a gap or damage, or its snapshot is missing.
  bool play(const loop::TickRecord& taped, loop::TickOutput& out);
  // Records are missing: no tick is played before the next keyframe.
  void lose_step() noexcept { in_step_ = has_snapshot_ = false; }

  const loop::HapticLoop& loop() const noexcept { return *loop_; }
  // Of the last tick that adopted a snapshot and was played; without the governor's number of members.
  const haptics::SubWorldReport& report() const noexcept { return *sink_; }

 private:
  std::unique_ptr<loop::HapticLoop> loop_;
  std::vector<std::byte> keyframe_;
  std::unique_ptr<haptics::WorldSnapshot> snapshot_;
  std::unique_ptr<haptics::SubWorldReport> sink_;
  bool in_step_{false}, has_snapshot_{false};
};

// The error for a record that is not what its kind says.
Status bad_record(const loop::TapeRecord& record, const std::string& what);

}  // namespace tactus::session
