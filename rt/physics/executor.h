// Who does work whose parts may be done in any order: the caller alone, or the caller with threads of whoever injects
// them. Parts write to places of their own, so results never depend on who did what.
//
// A function and its context, so that the engine knows no thread; the default costs a comparison. Thread: [rt] by the
// owner of what is worked on; the haptic loop never shares its work. Bound: the work's own.
#pragma once

#include <cstdint>
#include <type_traits>

namespace tactus::physics {

class Executor {
 public:
  using Work = void (*)(void* context, std::uint32_t begin, std::uint32_t end) noexcept;
  // Calls `work` on ranges that make up [0, count), on any thread, and returns when all is done. No range need be
  // shorter than `grain`. What was written before is seen by every range, what they write is seen after.
  using Share = void (*)(void* self, std::uint32_t count, std::uint32_t grain, Work work, void* context) noexcept;

  Executor() = default;
  Executor(Share share, void* self) noexcept : share_(share), self_(self) {}

  bool shares() const noexcept { return share_ != nullptr; }

  // `f(begin, end)`, noexcept. `grain`: fewer of them than this take less time than handing them over.
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
