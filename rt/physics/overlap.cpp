#include "rt/physics/overlap.h"

#include <algorithm>
#include <limits>

namespace tactus::physics {

double thickness(const Shape& shape) noexcept {
  const bool surface = shape.kind == ShapeKind::kPlane || shape.kind == ShapeKind::kMesh;
  return surface ? std::numeric_limits<double>::infinity() : 2.0 * half_thickness(shape);
}

double thinnest(std::span<const Body> bodies) noexcept {
  double least = std::numeric_limits<double>::infinity();
  for (const Body& body : bodies) least = std::min(least, thickness(body.shape));
  return least;
}

Overlap deepest_overlap(const World& world) noexcept {
  Overlap most;
  for (const Contact& contact : world.contacts()) {
    double depth{};
    for (std::uint32_t i = 0; i < contact.count; ++i) depth = std::max(depth, -contact.points[i].separation);
    if (!(depth > 0.0)) continue;
    const Body& a = world.bodies()[contact.slot_a];
    const Body& b = contact.b_fixed ? world.fixed_bodies()[contact.slot_b] : world.bodies()[contact.slot_b];
    const double share = depth / std::min(thickness(a.shape), thickness(b.shape));
    if (share > most.share) most = {.share = share, .depth = depth, .a = a.id, .b = b.id};
  }
  return most;
}

}  // namespace tactus::physics
