// The overlap of bodies relative to their thickness: 1 mm is negligible for a cube of 1 m and the whole thickness of a
// card.
//
// Frame: world. Units: m. Thread: [any], read only. Bound: visits each contact of the last step once. A contact's
// overlap is that at the start of the step, as in StepReport::deepest_m.
#pragma once

#include <span>

#include "rt/physics/world.h"

namespace tactus::physics {

// Extent of the thinnest side [m]; infinite for a plane or a mesh.
double thickness(const Shape& shape) noexcept;

// Smallest thickness of these bodies [m]; infinite if none has one.
double thinnest(std::span<const Body> bodies) noexcept;

struct Overlap {
  double share{};  // depth / thickness of the thinner body
  double depth{};  // m
  BodyId a{kNoBody}, b{kNoBody};
};

// The contact with the largest share; zero if nothing overlaps.
Overlap deepest_overlap(const World& world) noexcept;

}  // namespace tactus::physics
