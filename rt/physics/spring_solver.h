// Takes a PoseSpring into its body, one sub-step at a time; the formula is in pose_spring.h.
//
// From `hold` to `release` the body is as heavy as it feels, M + h (B + h K), to everything that pushes it: contacts,
// joints and border contacts are solved with the spring, not against it. Around what acts over the whole sub-step
// (gravity, wrenches) the body has its own mass. The error is that of the start of the sub-step. Frame: world. Units:
// SI. Thread: [rt].
#pragma once

#include "rt/physics/pose_spring.h"
#include "rt/physics/solver_body.h"

namespace tactus::physics {

template <class T>
class SpringSolver {
 public:
  // Nothing happens where the spring is off; where its body is frozen it keeps its velocity. Leaves the body held.
  void prepare(PoseSpring<T>& spring, const Pose<T>& start, std::span<SolverBody<T>> motion,
               std::span<SymMat3<T>> inverse_inertia, T h) noexcept;
  void release() noexcept;              // at the start of a sub-step
  void hold(std::uint32_t j) noexcept;  // in sub-step j, after the forces: also makes the velocity the spring's
  // Before and after the bodies move: the gyroscopic term turns the body as heavy as it feels, too.
  void note_turning() noexcept;
  void resist_turning() noexcept;
  void end_sub_step() noexcept;

 private:
  struct Mobility {
    T inverse_mass{};
    SymMat3<T> inverse_inertia;
  };
  void give(const Mobility& mobility) noexcept {
    body_->inverse_mass = mobility.inverse_mass, *inverse_inertia_ = mobility.inverse_inertia;
  }

  PoseSpring<T>* spring_{nullptr};
  SolverBody<T>* body_{nullptr};
  SymMat3<T>* inverse_inertia_{nullptr};
  Pose<T> start_;
  T h_{};
  Mobility own_, held_;
  T mass_{};
  SymMat3<T> inertia_;
  T linear_gain_{}, angular_gain_{};  // kg, kg m^2: h (B + h K)
  Vec3<T> linear_pull_;               // N s: -h K e of this sub-step
  Vec3<T> angular_pull_;              // N m s
  Vec3<T> turning_;                   // rad/s, before the body moves
};

}  // namespace tactus::physics
