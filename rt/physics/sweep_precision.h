// The number type in which a world's contacts are solved. Thread: [any].
#pragma once

#include <cstdint>

namespace tactus::physics {

// kFull: double, as the world. kSingle: float in the sweeps (solver.h); in a large world that takes about half the
// time, and velocities have a relative error of about 1e-7. Border contacts need kFull.
enum class SweepPrecision : std::uint8_t { kFull, kSingle };

}  // namespace tactus::physics
