#include "rt/physics/spring_solver.h"

namespace tactus::physics {

template <class S>
void SpringSolver<S>::prepare(const PoseSpring& spring, const Posed& start, std::span<SolverBody<S>> motion,
                              std::span<SymMat3<S>> inverse_inertia, S h) noexcept {
  body_ = nullptr;
  impulse_ = {};
  if (!spring.enabled) return;
  body_ = &motion[number_of(spring.slot)];
  inverse_inertia_ = &inverse_inertia[number_of(spring.slot)];
  h_ = h;
  error_ = number_cast<S>(start.position - spring.target.position);
  start_rotation_ = number_cast<S>(start.rotation);
  target_rotation_ = number_cast<S>(spring.target.rotation);
  target_velocity_ = {number_cast<S>(spring.target_velocity.linear), number_cast<S>(spring.target_velocity.angular)};
  stiffness_N_per_m_ = static_cast<S>(spring.stiffness_N_per_m);
  stiffness_Nm_per_rad_ = static_cast<S>(spring.stiffness_Nm_per_rad);
  linear_gain_ = h * (static_cast<S>(spring.damping_Ns_per_m) + h * stiffness_N_per_m_);
  angular_gain_ = h * (static_cast<S>(spring.damping_Nms_per_rad) + h * stiffness_Nm_per_rad_);
  own_ = held_ = {body_->inverse_mass, *inverse_inertia_};
  if (own_.inverse_mass == S(0)) return;
  mass_ = S(1) / own_.inverse_mass;
  inertia_ = inverse(own_.inverse_inertia);
  if (linear_gain_ > S(0)) held_.inverse_mass = S(1) / (mass_ + linear_gain_);
  if (angular_gain_ > S(0)) held_.inverse_inertia = inverse(inertia_ + SymMat3<S>::identity(angular_gain_));
  give(held_);
}

template <class S>
void SpringSolver<S>::release() noexcept {
  if (on()) give(own_);
}

template <class S>
void SpringSolver<S>::hold(std::uint32_t j) noexcept {
  if (!on()) return;
  // The gain accounts for the motion of body and target within h, so the error is that at the start of the sub-step.
  const S elapsed = static_cast<S>(j) * h_;
  const Vec3<S> error = error_ + body_->delta_position - elapsed * target_velocity_.linear;
  const Quat<S> target = quat_from_rotation_vector(elapsed * target_velocity_.angular) * target_rotation_;
  const Vec3<S> turned = small_rotation_vector(body_->delta_rotation * start_rotation_ * conjugate(target));
  linear_pull_ = -(h_ * stiffness_N_per_m_) * error;
  angular_pull_ = -(h_ * stiffness_Nm_per_rad_) * turned;
  if (own_.inverse_mass == S(0)) return;
  give(held_);
  if (linear_gain_ > S(0))
    body_->v = held_.inverse_mass * (mass_ * body_->v + linear_gain_ * target_velocity_.linear + linear_pull_);
  if (angular_gain_ > S(0))
    body_->w = held_.inverse_inertia * (inertia_ * body_->w + angular_gain_ * target_velocity_.angular + angular_pull_);
}

template <class S>
void SpringSolver<S>::save_angular_velocity() noexcept {
  if (on()) turning_ = body_->w;
}

template <class S>
void SpringSolver<S>::apply_held_inertia() noexcept {
  if (!on() || body_->w == turning_ || angular_gain_ == S(0)) return;
  body_->w = turning_ + held_.inverse_inertia * (inertia_ * (body_->w - turning_));
}

template <class S>
void SpringSolver<S>::end_sub_step() noexcept {
  if (!on()) return;
  impulse_.force += linear_pull_ - linear_gain_ * (body_->v - target_velocity_.linear);
  impulse_.torque += angular_pull_ - angular_gain_ * (body_->w - target_velocity_.angular);
}

template class SpringSolver<double>;
template class SpringSolver<float>;

}  // namespace tactus::physics
