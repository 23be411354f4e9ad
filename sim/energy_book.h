// Does a world have more energy than it was given? The book of its energy beside the device's work.
//
//   X = kinetic + potential - work of the coupling on the proxy     S: of the contacts' springs, all at t_n
// X + S never rises in a world that only loses energy by itself: friction, damping, blows. By how much X is above the
// least that X + S was before is unexplained. S counts on one side alone: what a deep overlap could give is not yet
// motion, and contacts push out no faster than they may. That can be said only where nothing else does work: no body on
// a script, no driven joint, no attraction, no restitution. Every kEvery-th cycle: a global step of thousands must not
// wait for its book.
// Thread: the global world's. Units: J.
#pragma once

#include <algorithm>
#include <limits>

#include "rt/physics/world.h"

namespace tactus::sim {

struct Scene;

struct EnergyBook {
  static constexpr unsigned kEvery = 4;

  bool complete{false};  // it is kept, and nothing does work that it does not have
  unsigned cycles{0};    // since the scene began
  double most_kinetic_J{0};
  double proxy_work_J{0};   // by now
  double work_in_J{0};      // of it, what was put in: the rises alone
  double unexplained_J{0};  // most that X was above the least of X + S before
  double least_J{std::numeric_limits<double>::infinity()};

  void add(double kinetic_J, double potential_J, double springs_J, double work_J) noexcept {
    const double x_J = kinetic_J + potential_J - work_J;
    least_J = std::min(least_J, x_J + springs_J);
    unexplained_J = std::max(unexplained_J, x_J - least_J);
    most_kinetic_J = std::max(most_kinetic_J, kinetic_J);
    work_in_J += std::max(0.0, work_J - proxy_work_J);
    proxy_work_J = work_J;
  }
  bool due() noexcept { return complete && cycles++ % kEvery == 0; }
  // The scene is as it was at the start; what was done before does not count.
  void reset() noexcept {
    cycles = 0;
    least_J = std::numeric_limits<double>::infinity();
  }
  // What the unexplained is held against.
  double in_play_J() const noexcept { return std::max(most_kinetic_J, work_in_J); }
};

// Is gravity, friction, damping and the hand all that does work in this scene?
bool energy_can_be_booked(const Scene& scene) noexcept;

// Of the contacts that the last step found, where its bodies are now: k e^2 / 2 with k = m w^2 of each point and e
// what it overlaps beyond the slop that contacts leave alone.
double contact_springs_J(const physics::World& world, double contact_hertz, double slop_m) noexcept;

}  // namespace tactus::sim
