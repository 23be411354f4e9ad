// How deep bodies lie in each other, as a share of how thick they are: a millimetre is nothing to a cube of a metre and
// all of a card.
//
// Frame: world. Units: m. Thread: [any], read only. Bound: the contacts of the last step, once. A contact's overlap is
// that at the start of the step, as StepReport::deepest_m has it.
#pragma once

#include <span>

#include "rt/physics/world.h"

namespace tactus::physics {

// Across the thinnest side; a plane and a mesh have no thickness of their own and do not count.
double thickness(const Shape& shape) noexcept;

// Of all these bodies the thinnest; infinite where none has a thickness.
double thinnest(std::span<const Body> bodies) noexcept;

struct Overlap {
  double share{};  // of the thinner body's thickness
  double depth{};  // m
  BodyId a{kNoBody}, b{kNoBody};
};

// The largest share among the contacts; zero where nothing overlaps.
Overlap deepest_overlap(const World& world) noexcept;

}  // namespace tactus::physics
