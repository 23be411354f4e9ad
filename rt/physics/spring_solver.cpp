#include "rt/physics/spring_solver.h"

namespace tactus::physics {

template <class T>
void SpringSolver<T>::prepare(PoseSpring<T>& spring, const Pose<T>& start, std::span<SolverBody<T>> motion,
                              std::span<SymMat3<T>> inverse_inertia, T h) noexcept {
  spring_ = nullptr;
  spring.step_impulse = {};
  if (!spring.enabled) return;
  spring_ = &spring, body_ = &motion[spring.slot], inverse_inertia_ = &inverse_inertia[spring.slot];
  start_ = start, h_ = h;
  linear_gain_ = h * (spring.damping_Ns_per_m + h * spring.stiffness_N_per_m);
  angular_gain_ = h * (spring.damping_Nms_per_rad + h * spring.stiffness_Nm_per_rad);
  own_ = held_ = {body_->inverse_mass, *inverse_inertia_};
  if (own_.inverse_mass == T(0)) return;
  mass_ = T(1) / own_.inverse_mass, inertia_ = inverse(own_.inverse_inertia);
  if (linear_gain_ > T(0)) held_.inverse_mass = T(1) / (mass_ + linear_gain_);
  if (angular_gain_ > T(0)) held_.inverse_inertia = inverse(inertia_ + SymMat3<T>::identity(angular_gain_));
  give(held_);
}

template <class T>
void SpringSolver<T>::release() noexcept {
  if (spring_ != nullptr) give(own_);
}

template <class T>
void SpringSolver<T>::hold(std::uint32_t j) noexcept {
  if (spring_ == nullptr) return;
  // The gain moves body and target on by h: the error is that of the start of the sub-step.
  const T elapsed = static_cast<T>(j) * h_;
  const Vec3<T> error =
      start_.position + body_->delta_position - (spring_->target.position + elapsed * spring_->target_velocity.linear);
  const Quat<T> target =
      quat_from_rotation_vector(elapsed * spring_->target_velocity.angular) * spring_->target.rotation;
  const Vec3<T> turned = small_rotation_vector(body_->delta_rotation * start_.rotation * conjugate(target));
  linear_pull_ = -(h_ * spring_->stiffness_N_per_m) * error;
  angular_pull_ = -(h_ * spring_->stiffness_Nm_per_rad) * turned;
  if (own_.inverse_mass == T(0)) return;
  give(held_);
  const Twist<T>& target_velocity = spring_->target_velocity;
  if (linear_gain_ > T(0))
    body_->v = held_.inverse_mass * (mass_ * body_->v + linear_gain_ * target_velocity.linear + linear_pull_);
  if (angular_gain_ > T(0))
    body_->w = held_.inverse_inertia * (inertia_ * body_->w + angular_gain_ * target_velocity.angular + angular_pull_);
}

template <class T>
void SpringSolver<T>::note_turning() noexcept {
  if (spring_ != nullptr) turning_ = body_->w;
}

template <class T>
void SpringSolver<T>::resist_turning() noexcept {
  if (spring_ == nullptr || body_->w == turning_ || angular_gain_ == T(0)) return;
  body_->w = turning_ + held_.inverse_inertia * (inertia_ * (body_->w - turning_));
}

template <class T>
void SpringSolver<T>::end_sub_step() noexcept {
  if (spring_ == nullptr) return;
  spring_->step_impulse.force += linear_pull_ - linear_gain_ * (body_->v - spring_->target_velocity.linear);
  spring_->step_impulse.torque += angular_pull_ - angular_gain_ * (body_->w - spring_->target_velocity.angular);
}

template class SpringSolver<double>;
template class SpringSolver<float>;

}  // namespace tactus::physics
