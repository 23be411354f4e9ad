// Runs a loop whose parts may run in any order: in the calling thread alone, or shared with the threads of an injected
// executor. Each part writes only its own elements, so results do not depend on which thread ran which part.
//
// A function pointer and its context, so that the engine depends on no thread library; the default costs one
// comparison. Thread: [rt], by the owner of the data; the haptic loop never shares its work. Bound: that of the work.
#pragma once

#include <cstdint>
#include <type_traits>

namespace tactus::physics {

class Executor {
 public:
  using Work = void (*)(void* context, std::uint32_t begin, std::uint32_t end) noexcept;
  // Calls `work` on ranges that together cover [0, count), on any threads, and returns when all are done. Ranges need
  // not be shorter than `grain`. Every range sees what the caller wrote before; the caller sees what the ranges wrote.
  using Share = void (*)(void* self, std::uint32_t count, std::uint32_t grain, Work work, void* context) noexcept;

  Executor() = default;
  Executor(Share share, void* self) noexcept : share_(share), self_(self) {}

  bool shares() const noexcept { return share_ != nullptr; }

  // Calls `f(begin, end)`, noexcept. `grain`: the least number of elements whose work takes longer than handing them to
  // another thread.
  template <class F>
  void for_each_range(std::uint32_t count, std::uint32_t grain, F&& f) const noexcept {
    if (share_ == nullptr || count < 2 * grain) {
      f(std::uint32_t{0}, count);
      return;
    }
    using Function = std::remove_reference_t<F>;
    share_(
        self_, count, grain,
        [](void* context, std::uint32_t begin, std::uint32_t end) noexcept {
          (*static_cast<Function*>(context))(begin, end);
        },
        const_cast<std::remove_const_t<Function>*>(&f));
  }

 private:
  Share share_{nullptr};
  void* self_{nullptr};
};

}  // namespace tactus::physics
