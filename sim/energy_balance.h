// Energy balance of the global world against the device's work: detects energy that the simulation creates.
//
//   X = kinetic + potential - work of the coupling on the proxy     S: energy of the springs of contacts and joints;
//   all at t_n
// X + S never rises in a world that only dissipates: friction, damping, impacts. The excess of X over the minimum of
// earlier X + S is unexplained. S counts in the minimum only: the energy stored in a deep overlap is not yet motion,
// and the push-out speed of contacts is limited. Valid only if nothing else does work: no scripted body, no driven
// joint, no attraction, no restitution. Updated every kEvery-th cycle, to spare the global step of thousands of bodies.
// Thread: the global world's. Units: J.
#pragma once

#include <algorithm>
#include <limits>

#include "rt/physics/world.h"

namespace tactus::sim {

struct Scene;

struct EnergyBalance {
  static constexpr unsigned kEvery = 4;

  bool complete{false};  // the balance is kept: it covers everything that does work in this scene
  unsigned cycles{0};    // since the scene's start or reset
  double most_kinetic_J{0};
  double proxy_work_J{0};                                   // work of the coupling on the proxy, up to now
  double work_in_J{0};                                      // sum of its increases
  double unexplained_J{0};                                  // max of X - least_J
  double least_J{std::numeric_limits<double>::infinity()};  // min of X + S

  void add(double kinetic_J, double potential_J, double springs_J, double work_J) noexcept {
    const double x_J = kinetic_J + potential_J - work_J;
    least_J = std::min(least_J, x_J + springs_J);
    unexplained_J = std::max(unexplained_J, x_J - least_J);
    most_kinetic_J = std::max(most_kinetic_J, kinetic_J);
    work_in_J += std::max(0.0, work_J - proxy_work_J);
    proxy_work_J = work_J;
  }
  bool due() noexcept { return complete && cycles++ % kEvery == 0; }
  // Call at a reset of the scene: the minimum starts again, the maxima stay.
  void reset() noexcept {
    cycles = 0;
    least_J = std::numeric_limits<double>::infinity();
  }
  // The energy that unexplained_J is compared with.
  double in_play_J() const noexcept { return std::max(most_kinetic_J, work_in_J); }
};

// True if only gravity, friction, damping and the hand do work in this scene.
bool energy_balance_is_complete(const Scene& scene) noexcept;

// Energy of the springs of the last step [J]: of contacts, k e^2 / 2 summed over the points at the present poses, k = m
// w^2, e: the overlap beyond the slop; and of joints (physics::Joints::springs_J).
double springs_J(const physics::World& world, double contact_hertz, double slop_m) noexcept;

}  // namespace tactus::sim
