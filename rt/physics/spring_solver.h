// Solves the six rows of a PoseSpring, one sub-step at a time; the formula is in pose_spring.h.
//
// Its error is that of the start of the sub-step in every sweep of that sub-step: then all sweeps solve one and the
// same implicit equation, and the impulse is the spring's and not a correction. Frame: world. Units: SI. Thread: [rt].
#pragma once

#include "rt/physics/pose_spring.h"
#include "rt/physics/solver_body.h"

namespace tactus::physics {

template <class T>
class SpringSolver {
 public:
  // Does nothing until `finish` where the spring is off. `impulse_scale` as for contacts.
  void prepare(PoseSpring<T>& spring, const Pose<T>& start, SolverBodies<T> bodies, T h, T impulse_scale) noexcept;
  // Error of sub-step j; applies the last impulse.
  void begin_sub_step(std::uint32_t j, SolverBodies<T> bodies) noexcept;
  void solve(SolverBodies<T> bodies) noexcept;
  void end_sub_step() noexcept;

 private:
  PoseSpring<T>* spring_{nullptr};
  Pose<T> start_;
  T h_{};
  T linear_gain_{}, angular_gain_{};  // g of the header; 0 where that half of the spring is off
  T linear_rate_{}, angular_rate_{};  // b
  T linear_mass_{};
  SymMat3<T> angular_mass_;
  Vec3<T> linear_error_, angular_error_;
};

}  // namespace tactus::physics
