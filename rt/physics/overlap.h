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
template <class T>
T thickness(const Shape<T>& shape) noexcept {
  const bool surface = shape.kind == ShapeKind::kPlane || shape.kind == ShapeKind::kMesh;
  return surface ? std::numeric_limits<T>::infinity() : T(2) * half_thickness(shape);
}

// Of all these bodies the thinnest; infinite where none has a thickness.
template <class T>
T thinnest(std::span<const Body<T>> bodies) noexcept {
  T least = std::numeric_limits<T>::infinity();
  for (const Body<T>& body : bodies) least = std::min(least, thickness(body.shape));
  return least;
}

template <class T>
struct Overlap {
  T share{};  // of the thinner body's thickness
  T depth{};  // m
  BodyId a{kNoBody}, b{kNoBody};
};

// The largest share among the contacts; zero where nothing overlaps.
template <class T>
Overlap<T> deepest_overlap(const World<T>& world) noexcept {
  Overlap<T> most;
  for (const Contact<T>& contact : world.contacts()) {
    T depth{};
    for (std::uint32_t i = 0; i < contact.count; ++i) depth = std::max(depth, -contact.points[i].separation);
    if (!(depth > T(0))) continue;
    const Body<T>& a = world.bodies()[contact.slot_a];
    const Body<T>& b = contact.b_fixed ? world.fixed_bodies()[contact.slot_b] : world.bodies()[contact.slot_b];
    const T share = depth / std::min(thickness(a.shape), thickness(b.shape));
    if (share > most.share) most = {share, depth, a.id, b.id};
  }
  return most;
}

}  // namespace tactus::physics
