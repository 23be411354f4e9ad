// The stages of a tick, and the observer that lets a caller with a clock time them: tick() itself has none.
//
// The observer is a function and its context, like the cut predicate. The default is none and costs a tick four
// comparisons. Thread: [rt], must not block. The end of collision detection is not a stage of its own: it is the first
// call of the cut predicate, before the first sweep.
#pragma once

#include <cstdint>

namespace tactus::loop {

enum class TickStage : std::uint32_t {
  kAdopt = 0,   // the sample is guarded, the snapshot adopted, the report published
  kCouple = 1,  // arming is done, the coupling's target is set
  kStep = 2,    // the sub-world is stepped
};

struct StageObserver {
  void (*done)(void* context, TickStage stage) noexcept {nullptr};
  void* context{nullptr};

  void operator()(TickStage stage) const noexcept {
    if (done != nullptr) done(context, stage);
  }
};

}  // namespace tactus::loop
