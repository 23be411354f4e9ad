// How deep bodies lie in each other, as a share of how thick they are: a millimetre is nothing to a cube of a metre and
// all of a card.
//
// Frame: world. Units: m. Thread: [any], read only. Bound: the contacts of the last step, once. A contact's overlap is
// that at the start of the step, as StepReport::deepest_m has it.
#pragma once

#include <algorithm>
#include <limits>
#include <span>

#include "rt/physics/passes.h"
#include "rt/physics/world.h"

namespace tactus::physics {

// Across the thinnest side; a plane and a mesh have no thickness of their own and do not count.
inline double thickness(const Shape& shape) noexcept {
  const bool surface = shape.kind == ShapeKind::kPlane || shape.kind == ShapeKind::kMesh;
  return surface ? std::numeric_limits<double>::infinity() : 2.0 * half_thickness(shape);
}

// Of all these bodies the thinnest; infinite where none has a thickness.
inline double thinnest(std::span<const Body> bodies) noexcept {
  double least = std::numeric_limits<double>::infinity();
  for (const Body& body : bodies) least = std::min(least, thickness(body.shape));
  return least;
}

struct Overlap {
  double share{};  // of the thinner body's thickness
  double depth{};  // m
  BodyId a{kNoBody}, b{kNoBody};
};

// The largest share among the contacts; zero where nothing overlaps.
inline Overlap deepest_overlap(const World& world) noexcept {
  Overlap most;
  for (const Contact& contact : world.contacts()) {
    double depth{};
    for (std::uint32_t i = 0; i < contact.count; ++i) depth = std::max(depth, -contact.points[i].separation);
    if (!(depth > 0.0)) continue;
    const Body& a = world.bodies()[contact.slot_a];
    const Body& b = contact.b_fixed ? world.fixed_bodies()[contact.slot_b] : world.bodies()[contact.slot_b];
    const double share = depth / std::min(thickness(a.shape), thickness(b.shape));
    if (share > most.share) most = {share, depth, a.id, b.id};
  }
  return most;
}

}  // namespace tactus::physics
