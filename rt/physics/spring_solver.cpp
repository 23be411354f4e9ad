#include "rt/physics/spring_solver.h"

namespace tactus::physics {

template <class T>
void SpringSolver<T>::prepare(PoseSpring<T>& spring, const Pose<T>& start, SolverBodies<T> bodies, T h,
                              T impulse_scale) noexcept {
  spring_ = spring.enabled ? &spring : nullptr;
  spring.step_impulse = {};
  if (spring_ == nullptr) return;
  start_ = start;
  h_ = h;
  if (impulse_scale != T(1)) spring.impulse.force *= impulse_scale, spring.impulse.torque *= impulse_scale;
  const T linear = spring.damping_Ns_per_m + h * spring.stiffness_N_per_m;
  const T angular = spring.damping_Nms_per_rad + h * spring.stiffness_Nm_per_rad;
  linear_gain_ = invert_or_zero(h * linear), angular_gain_ = invert_or_zero(h * angular);
  linear_rate_ = linear > T(0) ? spring.stiffness_N_per_m / linear : T(0);
  angular_rate_ = angular > T(0) ? spring.stiffness_Nm_per_rad / angular : T(0);
  if (linear_gain_ == T(0)) spring.impulse.force = {};
  if (angular_gain_ == T(0)) spring.impulse.torque = {};
  linear_mass_ = linear_gain_ > T(0) ? T(1) / (bodies.motion[spring.slot].inverse_mass + linear_gain_) : T(0);
  angular_mass_ = angular_gain_ > T(0)
                      ? inverse(bodies.inverse_inertia[spring.slot] + SymMat3<T>::identity(angular_gain_))
                      : SymMat3<T>{};
}

template <class T>
void SpringSolver<T>::begin_sub_step(std::uint32_t j, SolverBodies<T> bodies) noexcept {
  if (spring_ == nullptr) return;
  SolverBody<T>& body = bodies.motion[spring_->slot];
  const T elapsed = static_cast<T>(j) * h_;
  // The rows' velocity term moves body and target on by h: the error is that of the start of the sub-step.
  linear_error_ =
      start_.position + body.delta_position - (spring_->target.position + elapsed * spring_->target_velocity.linear);
  const Quat<T> target =
      quat_from_rotation_vector(elapsed * spring_->target_velocity.angular) * spring_->target.rotation;
  angular_error_ = small_rotation_vector(body.delta_rotation * start_.rotation * conjugate(target));
  body.v += body.inverse_mass * spring_->impulse.force;
  body.w += bodies.inverse_inertia[spring_->slot] * spring_->impulse.torque;
}

template <class T>
void SpringSolver<T>::solve(SolverBodies<T> bodies) noexcept {
  if (spring_ == nullptr) return;
  SolverBody<T>& body = bodies.motion[spring_->slot];
  Wrench<T>& sum = spring_->impulse;
  const Vec3<T> linear = -linear_mass_ * (body.v - spring_->target_velocity.linear + linear_rate_ * linear_error_ +
                                          linear_gain_ * sum.force);
  sum.force += linear;
  body.v += body.inverse_mass * linear;
  const Vec3<T> angular = -(angular_mass_ * (body.w - spring_->target_velocity.angular +
                                             angular_rate_ * angular_error_ + angular_gain_ * sum.torque));
  sum.torque += angular;
  body.w += bodies.inverse_inertia[spring_->slot] * angular;
}

template <class T>
void SpringSolver<T>::end_sub_step() noexcept {
  if (spring_ == nullptr) return;
  spring_->step_impulse.force += spring_->impulse.force;
  spring_->step_impulse.torque += spring_->impulse.torque;
}

template class SpringSolver<double>;
template class SpringSolver<float>;

}  // namespace tactus::physics
