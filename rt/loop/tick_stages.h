// The stages of a tick, and how a caller that has a clock learns when each is done: tick() itself has none.
//
// Given beside the cut predicate and in the same way, a function and its context; the default is nobody, and costs a
// tick four comparisons. Thread: [rt], must not block. Where contacts end and solving begins the cut predicate tells:
// it is first asked before the first sweep.
#pragma once

#include <cstdint>

namespace tactus::loop {

enum class TickStage : std::uint32_t {
  kAdopt = 0,   // the sample is guarded, the snapshot adopted, the report published
  kCouple = 1,  // armed or not, and where the device wants the proxy
  kStep = 2,    // the sub-world has moved
};

struct StageObserver {
  void (*done)(void* context, TickStage stage) noexcept {nullptr};
  void* context{nullptr};

  void operator()(TickStage stage) const noexcept {
    if (done != nullptr) done(context, stage);
  }
};

}  // namespace tactus::loop
