// Coulomb's coefficient of a pair of bodies: the geometric mean of theirs. Thread: [any]. Units: none.
#pragma once

#include <cmath>

#include "rt/physics/body.h"

namespace tactus::physics {

inline double pair_friction(const Body& a, const Body& b) noexcept { return std::sqrt(a.friction * b.friction); }

}  // namespace tactus::physics
