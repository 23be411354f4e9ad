// Solves a PoseSpring implicitly as part of its body, sub-step by sub-step; the formula is in pose_spring.h.
//
// From `hold` to `release` the body has the apparent mass M + h (B + h K), so contacts, joints and border contacts are
// solved together with the spring. While what acts over the whole sub-step (gravity, wrenches) is applied, the body has
// its own mass. The error is that at the start of the sub-step. S, the number type of the sweeps, may be narrower than
// double: the error at the start of the step is computed in double.
// Frame: world. Units: SI. Thread: [rt].
#pragma once

#include "rt/physics/pose_spring.h"
#include "rt/physics/solver_body.h"

namespace tactus::physics {

template <class S>
class SpringSolver {
 public:
  // Does nothing if the spring is disabled; keeps the velocity of a frozen body. Leaves the body held.
  void prepare(const PoseSpring& spring, const Posed& start, std::span<SolverBody<S>> motion,
               std::span<SymMat3<S>> inverse_inertia, S h) noexcept;
  bool on() const noexcept { return body_ != nullptr; }
  void release() noexcept;              // at the start of a sub-step: back to the body's own mass
  void hold(std::uint32_t j) noexcept;  // in sub-step j, after the forces: sets the apparent mass, adds the spring's
                                        // pull to the velocity
  // Before and after integration: the gyroscopic term uses the apparent inertia, too.
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
    body_->inverse_mass = mobility.inverse_mass;
    *inverse_inertia_ = mobility.inverse_inertia;
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
