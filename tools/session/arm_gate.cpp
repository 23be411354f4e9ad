#include "tools/session/arm_gate.h"

#include "rt/loop/haptic_loop.h"

namespace tactus::session {
namespace {

constexpr std::uint32_t kGivesForce = loop::kArm | loop::kRearm;

}  // namespace

std::uint32_t ArmGate::pass(std::uint32_t asked) noexcept {
  if (!same_device_) return asked;
  constexpr auto relaxed = std::memory_order_relaxed;
  if (unchecked_ticks_ > 0) {
    --unchecked_ticks_;
    return asked;
  }
  if ((asked & kGivesForce) != 0) waiting_.fetch_or(asked & kGivesForce, relaxed);
  // A disarm cancels waiting requests for force; they must be made again.
  if ((asked & loop::kDisarm) != 0) {
    waiting_.store(0, relaxed);
    granted_.store(0, relaxed);
  }
  std::uint32_t now = asked & ~kGivesForce;
  if (granted_.load(relaxed) != 0) now |= granted_.exchange(0, relaxed);
  return now;
}

Status ArmGate::look() {
  constexpr auto relaxed = std::memory_order_relaxed;
  const std::uint32_t waiting = waiting_.exchange(0, relaxed);
  if (waiting == 0) return Status::good();
  if (Status status = same_device_(); !status.ok()) return status;
  granted_.fetch_or(waiting, relaxed);
  return Status::good();
}

}  // namespace tactus::session
