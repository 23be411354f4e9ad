// How exactly a world's contacts are solved. Thread: [any].
#pragma once

#include <cstdint>

namespace tactus::physics {

// The numbers that contacts are solved with: the world's own, or single precision (solver.h). In a large world that
// takes about half the time, and speeds are exact to about 1e-7 of themselves. Spring and border need the world's own.
enum class SweepPrecision : std::uint8_t { kFull, kSingle };

}  // namespace tactus::physics
