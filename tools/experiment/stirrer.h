// Stirrer of a heap: upright rods that move together on circles, with prescribed poses regardless of contacts.
//
// One description for every engine: in each step an engine moves each rod at constant velocity from its pose at the
// start of the step to its pose at the end, as a kinematic body.
// Frame: that of the scene, z up. Units: SI. Thread: [any]; plain values and pure functions.
#pragma once

#include <cstdint>
#include <vector>

#include "rt/base/spatial.h"

namespace tactus::experiment {

struct Stirrer {
  Vec3d half_extents_m;          // of a rod: a box along the axes
  std::vector<Vec3d> centres_m;  // of the rods' circles, at the height of the rods' centres
  double radius_m{0};            // of the circles
  double speed_rad_per_s{0};     // along the circles; the rods do not turn

  // World from rod, at a time since the start of the scene.
  Posed pose_at(std::size_t rod, double time_s) const noexcept;
  Twistd velocity_at(double time_s) const noexcept;  // of every rod
  // The constant velocity that takes a rod in `step_s` from `position` to where it is to be at the end of the step.
  Twistd velocity_over(std::size_t rod, const Vec3d& position, double time_s, double step_s) const noexcept;
  double path_length_m(double duration_s) const noexcept;  // of a rod
};

// Rods for `bodies` bodies of at most `edge_m`, about fifty bodies per rod, on a square grid around the centre of the
// floor. Rods extend into the floor, so that no body gets under them. The walls must slope (add_bowl): between a rod of
// prescribed motion and an upright wall every engine crushes a row of bodies.
Stirrer make_stirrer(std::uint32_t bodies, double edge_m);
// Side of the square floor over which the rods move [m].
double floor_width(const Stirrer& stirrer, double edge_m) noexcept;

}  // namespace tactus::experiment
