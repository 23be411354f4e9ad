// A ghost: an outside body as this world represents it at the border, by its motion and its response to an impulse.
//
// The ghost moves as in the other world, under the contact impulse P_found that the other world found. A deviation from
// that impulse changes its velocity at once, by its admittance: v = u + W (P - P_found), u: velocity in the other
// world. W is the apparent admittance of everything that moves with the body: zero for a body held firmly by the
// ground; that of the whole row for the first body of a row. Frame: world. Units: SI. Thread: the owner of the World.
#pragma once

#include <algorithm>
#include <span>

#include "rt/base/ids.h"
#include "rt/base/spatial.h"

namespace tactus::physics {

// Change of a body's twist per impulse applied to it, both at its centre: symmetric, positive semidefinite.
template <class T>
struct AdmittanceOf {
  SymMat3<T> linear;   // m/s per N s
  SymMat3<T> angular;  // rad/s per N m s
  Vec3<T> crossed[3];  // row i: linear velocity i [m/s] per N m s; its transpose is rad/s per N s

  friend constexpr Twist<T> operator*(const AdmittanceOf& w, const Wrench<T>& p) noexcept {
    const Vec3<T>& f = p.force;
    return {
        w.linear * f + Vec3<T>{dot(w.crossed[0], p.torque), dot(w.crossed[1], p.torque), dot(w.crossed[2], p.torque)},
        w.angular * p.torque + f.x * w.crossed[0] + f.y * w.crossed[1] + f.z * w.crossed[2]};
  }
};
using Admittance = AdmittanceOf<double>;

struct BorderGhost {
  BodyId outside{kNoBody};
  Vec3d centre;           // m
  Twistd velocity;        // m/s, rad/s: of the centre
  Twistd drive;           // m/s^2, rad/s^2: acceleration by everything but this world's members
  Admittance admittance;  // at the centre
  Wrenchd total_impulse;  // N s, N m s about the centre: by the members, over the cycle
};

// A ghost during a step. The first twelve numbers are read in whole registers (ghost_row.cpp).
struct alignas(32) GhostState {
  Twistd velocity;
  Vec3d moved, turned;  // m, rad, since the start of the step
  Twistd before;        // before the warm start
  Twistd drive;
  Wrenchd impulse;  // N s, N m s, over the step
  Admittance admittance;
  BodyId outside{kNoBody};
};

inline constexpr std::uint32_t kNoGhost = 0xffffffffu;

// Index of the body's ghost in `ghosts`, which is sorted by id; kNoGhost if there is none.
template <class Ghost>
std::uint32_t find_ghost(std::span<Ghost> ghosts, BodyId outside) noexcept {
  const auto at = std::lower_bound(ghosts.begin(), ghosts.end(), outside,
                                   [](const Ghost& ghost, BodyId id) { return ghost.outside < id; });
  return at != ghosts.end() && at->outside == outside ? static_cast<std::uint32_t>(at - ghosts.begin()) : kNoGhost;
}

}  // namespace tactus::physics
