// A contact between two bodies of one world, kept from step to step: its manifold and its impulses.
//
// Sorted by pair key. Impulses are those of the last sub-step, in N s, and warm-start the next one; totals are sums
// over the step. Frame: world; normal from A (the lower id) to B. Thread: the owner of the World.
#pragma once

#include "rt/base/ids.h"
#include "rt/base/wide.h"
#include "rt/physics/collision/manifold.h"

namespace tactus::physics {

inline constexpr std::uint32_t kNoSlot = 0xffffffffu;

struct ContactPoint {
  Vec3d from_a, from_b;  // m, from the centres of A and B, world axes, at the start of the step
  double separation{};   // m, at the start of the step
  std::uint32_t feature{0};
  // The solver leaves the point out (redundant_points.h, flush_seams.h); set in every step.
  bool redundant{false};
  double normal_impulse{};        // N s, of the last sub-step
  double tangent_impulse[2]{};    // N s, of the last sub-step, along `tangents_of(normal)`
  double total_normal_impulse{};  // N s, over the step
  Vec3d total_friction{};         // N s, over the step, on B, world
};

struct Contact {
  PairKey key;
  std::uint32_t slot_a{0}, slot_b{0};   // of the world's bodies; of a fixed body: among the fixed bodies
  bool b_fixed{false};                  // true: B is a fixed body. A fixed body is always B.
  bool rolls_a{false}, rolls_b{false};  // true: touched on a surface of revolution (contact_row.h); never carried over
  bool may_be_flush{true};              // as in Manifold, and as FlushSeams::mark leaves it
  AxisCache axis_cache;
  // m: distance of the points from the centre of a ball, along the normal (contact_row.h); 0: neither. Never
  // carried over.
  double round_a{}, round_b{};
  double friction{};
  Vec3d normal;  // from A to B
  std::uint32_t count{0};
  std::array<ContactPoint, kMaxManifoldPoints> points;

  // True if a point overlaps, or pressed in the last step.
  bool touching() const noexcept {
    for (std::uint32_t i = 0; i < count; ++i)
      if (points[i].total_normal_impulse > 0.0 || points[i].separation <= 0.0) return true;
    return false;
  }
  // Separation of the deepest point [m].
  double least_separation() const noexcept {
    double least = points[0].separation;
    for (std::uint32_t i = 1; i < count; ++i) least = smaller(least, points[i].separation);
    return least;
  }
  // Makes the solver leave all points out.
  void leave_out() noexcept {
    for (std::uint32_t i = 0; i < count; ++i) {
      points[i].redundant = true;
      points[i].normal_impulse = points[i].tangent_impulse[0] = points[i].tangent_impulse[1] = 0.0;
    }
  }
  // True if the solver leaves all points out.
  bool is_redundant() const noexcept {
    for (std::uint32_t i = 0; i < count; ++i)
      if (!points[i].redundant) return false;
    return true;
  }
};

}  // namespace tactus::physics
