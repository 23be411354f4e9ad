// Work of position correction against gravity and against the devices' springs.
//
// A sub-step moves a body by h v', v' its velocity after the biased sweep. v' contains the speed at which an overlap is
// pushed out, or at which a soft contact or joint gives way; the relax sweep takes that speed out of the velocity. So
// what is pressed against a contact has a velocity of 0 at both ends of each sub-step, while it moves. The work of an
// impulse, the impulse times the mean of these velocities, is the change of kinetic energy, and lacks
//   W = -sum_i F_i . (dx_i - sum_j h (v_ij + v_i,j+1) / 2),   i: bodies, j: sub-steps, dx: displacement,
//   F: weight and, on a body that a device's spring holds, the mean of the spring's force; the same with its torque
// With W added, the work of all other impulses is the change of kinetic and potential energy, less the device's work.
// In free fall W is that of semi-implicit Euler, -m g^2 h^2 / 2 a sub-step. Frame: world. Units: SI. Thread: [any],
// pure. Bound: the number of bodies.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "rt/base/rotation_vector.h"
#include "rt/physics/body.h"
#include "rt/physics/pose_spring.h"
#include "rt/physics/solver_body.h"

namespace tactus::physics {

// W of the weight of one body: `displacement` dx, `path` the sum of h (v + v') / 2.
inline double push_out_J(const Body& body, const Vec3d& gravity, const Vec3d& displacement,
                         const Vec3d& path) noexcept {
  return -body.mass * body.gravity_scale * dot(gravity, displacement - path);
}

// W of a spring on its body: `force` the mean wrench, `moved` the displacement and rotation vector, `path` as above.
inline double push_out_J(const Wrenchd& force, const Twistd& moved, const Twistd& path) noexcept {
  return -dot(force.force, moved.linear - path.linear) - dot(force.torque, moved.angular - path.angular);
}

// Sums W over the bodies of one step that move. Call `pass` with h / 2 at the start of the step, with h between two
// sub-steps, with h / 2 at its end.
class PushOut {
 public:
  struct Step {
    std::span<const Body> bodies;
    std::span<const SolverBody<double>> motion;
    std::span<const PoseSpring> springs;  // kMaxSprings at most
    Vec3d gravity;
    double dt{};
  };

  void pass(const Step& step, double seconds) noexcept {
    for (std::uint32_t i = 0; i < step.motion.size(); ++i)
      if (step.motion[i].inverse_mass > 0.0)
        sum_J_ += push_out_J(step.bodies[i], step.gravity, {}, seconds * step.motion[i].v);
    for (std::uint32_t k = 0; k < step.springs.size(); ++k)
      if (step.springs[k].enabled) {
        const SolverBody<double>& body = step.motion[number_of(step.springs[k].slot)];
        path_[k] += Twistd{seconds * body.v, seconds * body.w};
      }
  }
  // [J], after the last sub-step, the springs' impulses known.
  double work_J(const Step& step) const noexcept {
    double sum_J = sum_J_;
    for (std::uint32_t i = 0; i < step.motion.size(); ++i)
      if (step.motion[i].inverse_mass > 0.0)
        sum_J += push_out_J(step.bodies[i], step.gravity, step.motion[i].delta_position, {});
    for (std::uint32_t k = 0; k < step.springs.size(); ++k) {
      const PoseSpring& spring = step.springs[k];
      if (!spring.enabled) continue;
      const SolverBody<double>& body = step.motion[number_of(spring.slot)];
      const Twistd moved{body.delta_position, small_rotation_vector(body.delta_rotation)};
      sum_J += push_out_J(spring.step_impulse * (1.0 / step.dt), moved, path_[k]);
    }
    return sum_J;
  }

 private:
  double sum_J_{0};
  std::array<Twistd, kMaxSprings> path_{};
};

}  // namespace tactus::physics
