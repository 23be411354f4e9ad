// Ranges that several tables of a scene file share. Thread: [setup].
#pragma once

#include "rt/text/table_reader.h"

namespace tactus::sim {

// Lengths and masses whose squares and inverses are far from the limits of a double, and of a float.
inline constexpr text::Range kLength{"a length", 1e-4, 1e3};
inline constexpr text::Range kMass{"a mass", 1e-6, 1e6};
inline constexpr text::Range kFriction{"a coefficient of friction", 0, 10};
// Of a coupling or of a hand, for translation (SI, per metre) and for rotation (per radian).
inline constexpr text::Range kStiffness{"a stiffness", 0, 1e5};
inline constexpr text::Range kDamping{"a damping", 0, 1e4};

}  // namespace tactus::sim
