// The two one-way double buffers between the haptic thread and the global world, and why no buffer is written while it
// is read.
//
//   haptic                                     global
//   reads G(n) (acquire), done with G(n-1)     reads H(n) (acquire)
//   writes H(n), publishes it (release)        writes G(n+1), publishes it (release)
//
// G(n+1) shares a buffer with G(n-1): the global side writes it only after it has read H(n), which the haptic side
// published after its last read of G(n-1). H(n) shares a buffer with H(n-2): the haptic side writes it only after it
// has read G(n), which the global side published after its last read of H(n-1). This also holds when the world is late:
// neither side skips a number. Thread: one haptic thread, one global thread; neither waits here, locks or wakes the
// other.
#pragma once

#include "rt/base/double_buffer.h"
#include "rt/haptics/coupling/snapshot.h"

namespace tactus::haptics {

struct Exchange {
  DoubleBuffer<WorldSnapshot> snapshots;  // G(n), written by the global side; G(0) is published before the first tick
  DoubleBuffer<SubWorldReport> reports;   // H(n), written by the haptic side
};

}  // namespace tactus::haptics
