// A body of another world as this world knows it at the border: its motion, and what an impulse does to it.
//
// The ghost moves as the other world found it to move under the load it found; what the load is off by moves it at
// once, by its admittance: v = u + W (P - P_found). W stands for all that moves with the body, so that a body on firm
// ground has none and the first of a row the row's. Frame: world. Units: SI. Thread: the owner of the World.
#pragma once

#include <algorithm>
#include <span>

#include "rt/base/ids.h"
#include "rt/base/spatial.h"

namespace tactus::physics {

// The change of a body's twist by an impulse on it, both at its centre: symmetric, not negative.
struct Admittance {
  SymMat3d linear;   // m/s per N s
  SymMat3d angular;  // rad/s per N m s
  Vec3d crossed[3];  // row i: velocity i [m/s] per N m s; its transpose is rad/s per N s

  friend constexpr Twistd operator*(const Admittance& w, const Wrenchd& p) noexcept {
    const Vec3d& f = p.force;
    return {w.linear * f + Vec3d{dot(w.crossed[0], p.torque), dot(w.crossed[1], p.torque), dot(w.crossed[2], p.torque)},
            w.angular * p.torque + f.x * w.crossed[0] + f.y * w.crossed[1] + f.z * w.crossed[2]};
  }
};

struct BorderGhost {
  BodyId outside{kNoBody};
  Vec3d centre;           // m
  Twistd velocity;        // of the centre, now
  Twistd drive;           // m/s^2, rad/s^2: by all that acts on it but this world's members
  Admittance admittance;  // of the centre
  Wrenchd total_impulse;  // N s, N m s about the centre: by the members, over the cycle
};

// A ghost within a step.
struct GhostState {
  BodyId outside{kNoBody};
  Twistd velocity, before;  // now; before the warm start
  Twistd drive;
  Vec3d moved, turned;  // m, rad, since the start of the step
  Wrenchd impulse;      // N s, N m s, over the step
  Admittance admittance;
};

inline constexpr std::uint32_t kNoGhost = 0xffffffffu;

// The index of the ghost of that body, among ghosts by id; kNoGhost: there is none.
template <class Ghost>
std::uint32_t find_ghost(std::span<Ghost> ghosts, BodyId outside) noexcept {
  const auto at = std::lower_bound(ghosts.begin(), ghosts.end(), outside,
                                   [](const Ghost& ghost, BodyId id) { return ghost.outside < id; });
  return at != ghosts.end() && at->outside == outside ? static_cast<std::uint32_t>(at - ghosts.begin()) : kNoGhost;
}

}  // namespace tactus::physics
