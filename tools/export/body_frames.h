// The poses of the sub-world's bodies, by replaying the tape.
//
// Thread: normal. Frame: world. Bound: at most kMaxMembers bodies a frame. Bodies outside of the sub-world are not on
// the tape.
#pragma once

#include <vector>

#include "tools/export/sink.h"

namespace tactus::exporting {

class BodyFrames {
 public:
  // `scene`: must outlive this. `rate_Hz`: frames per second of simulated time; at most one a tick.
  BodyFrames(std::unique_ptr<loop::HapticLoop> loop, const sim::Scene& scene, double rate_Hz, double period_s);

  Status take(const loop::TapeRecord& record);  // a keyframe or a snapshot
  void play(const loop::TickRecord& taped);
  void lose_step() noexcept { player_.lose_step(); }

  // After play(): true if this tick is the first in its frame's interval and was played.
  bool due(const loop::TickRecord& taped);
  ExportedFrame frame(const loop::TickRecord& taped);

  std::uint64_t different() const noexcept { return different_; }        // ticks with another output than the tape's
  std::uint64_t unreplayable() const noexcept { return unreplayable_; }  // ticks that could not be played

 private:
  session::TapePlayer player_;
  const sim::Scene& scene_;
  double rate_Hz_, period_s_;
  std::uint64_t next_frame_{0};
  bool played_{false};
  std::uint64_t different_{0}, unreplayable_{0};
  std::vector<ExportedBody> states_;
};

}  // namespace tactus::exporting
