// Takes a PoseSpring into its body, one sub-step at a time; the formula is in pose_spring.h.
//
// From `hold` to `release` the body is as heavy as it feels, M + h (B + h K), to everything that pushes it: contacts,
// joints and border contacts are solved with the spring, not against it. Around what acts over the whole sub-step
// (gravity, wrenches) the body has its own mass. The error is that of the start of the sub-step. Frame: world. Units:
// SI. Thread: [rt]. The sweeps' numbers, S, may be narrower than the world's: the error at the start of the step is
// taken in double.
#pragma once

#include "rt/physics/pose_spring.h"
#include "rt/physics/solver_body.h"

namespace tactus::physics {

template <class S>
class SpringSolver {
 public:
  // Nothing happens where the spring is off; where its body is frozen it keeps its velocity. Leaves the body held.
  void prepare(const PoseSpring& spring, const Posed& start, std::span<SolverBody<S>> motion,
               std::span<SymMat3<S>> inverse_inertia, S h) noexcept;
  bool on() const noexcept { return body_ != nullptr; }
  void release() noexcept;              // at the start of a sub-step
  void hold(std::uint32_t j) noexcept;  // in sub-step j, after the forces: also makes the velocity the spring's
  // Before and after the bodies move: the gyroscopic term turns the body as heavy as it feels, too.
  void save_angular_velocity() noexcept;
  void apply_held_inertia() noexcept;
  void end_sub_step() noexcept;
  const Wrench<S>& impulse() const noexcept { return impulse_; }  // N s, N m s: sum over the step, on the body

 private:
  struct Mobility {
    S inverse_mass{};
    SymMat3<S> inverse_inertia;
  };
  void give(const Mobility& mobility) noexcept {
    body_->inverse_mass = mobility.inverse_mass, *inverse_inertia_ = mobility.inverse_inertia;
  }

  SolverBody<S>* body_{nullptr};
  SymMat3<S>* inverse_inertia_{nullptr};
  Vec3<S> error_;                             // m, of the body from the target: at the start of the step
  Quat<S> start_rotation_, target_rotation_;  // at the start of the step
  Twist<S> target_velocity_;
  S stiffness_N_per_m_{}, stiffness_Nm_per_rad_{};
  Wrench<S> impulse_;
  S h_{};
  Mobility own_, held_;
  S mass_{};
  SymMat3<S> inertia_;
  S linear_gain_{}, angular_gain_{};  // kg, kg m^2: h (B + h K)
  Vec3<S> linear_pull_;               // N s: -h K e of this sub-step
  Vec3<S> angular_pull_;              // N m s
  Vec3<S> turning_;                   // rad/s, before the body moves
};

}  // namespace tactus::physics
