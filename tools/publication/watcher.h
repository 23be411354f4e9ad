// A watcher's side of the shared memory (layout.h): copies the newest frame and the ticks since the last look.
//
// Offsets and counts in the memory are checked before use: whatever bytes it contains, nothing outside of it is read. A
// reader that is too slow loses whole values, never receives part of one, and counts the losses.
// Thread: one. Frame: world. Units: SI. Bound: a frame's copy by the number of bodies; at most one ring of ticks a
// call.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "rt/base/result.h"
#include "tools/publication/layout.h"

namespace tactus::publication {

struct Frame {
  std::uint64_t number{0};
  FrameHead head;
  std::vector<Position> positions;  // in the order of the moving bodies' ids; rotations and roles too
  std::vector<Rotation> rotations;
  std::vector<std::uint8_t> roles;  // RoleBit
  std::vector<ContactForce> contacts;
};

class Watcher {
 public:
  // Takes over the descriptor. Error, one line: no such memory, not sealed, or of another version.
  static Result<std::unique_ptr<Watcher>> open(int descriptor);
  ~Watcher();
  Watcher(const Watcher&) = delete;
  Watcher& operator=(const Watcher&) = delete;

  const std::string& text() const noexcept { return text_; }  // of a tape's header
  double period_s() const noexcept { return header_.period_s; }
  std::uint32_t bodies() const noexcept { return header_.bodies; }
  bool ended() const noexcept;  // the run is over: nothing new will come

  // The newest frame, if there is one that was not read yet. False: none, or the writer overtook the copy each time.
  bool read_frame(Frame& frame);
  // Appends the ticks since the last call, at most `most`, the oldest first. Returns how many were lost since then.
  // The first call begins at the newest tick.
  std::uint64_t read_ticks(std::vector<TickEntry>& ticks, std::size_t most);

  // The state of the run (StateSlot), if it is new. False: it is not, or the writer overtook the copy.
  bool read_state(std::string& state);

  std::uint64_t frames_missed() const noexcept { return frames_missed_; }  // written and not read

 private:
  Watcher(int descriptor, const std::byte* bytes, const Header& header);
  bool copy_frame(std::uint64_t number, Frame& frame) const;
  bool copy_tick(std::uint64_t number, TickEntry& tick) const;

  int descriptor_;
  const std::byte* bytes_;
  Header header_;
  std::string text_;
  std::uint64_t next_frame_{0}, next_tick_{0}, frames_missed_{0}, state_{0};
  bool began_{false};
};

}  // namespace tactus::publication
