// The contact manifold of two shapes: at most four points with one normal. The public interface of narrow phase.
//
// Frame: world; points are relative to each body's centre, so that positions far from the world's origin lose no
// precision. Thread: [any]; pure functions of shapes and poses, bounded work (box-box: 15 axes, one clip of a
// quadrilateral against four edges, eight projections if no face is opposite the other; hulls: hull_pair.h), no
// allocation.
// Source: separating axes, Gottschalk 1996; clipping, Liang and Barsky 1984 (boxes), Sutherland and Hodgman 1974
// (hulls).
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "rt/physics/shapes/shape.h"

namespace tactus::physics {

inline constexpr std::uint32_t kMaxManifoldPoints = 4;

struct ManifoldPoint {
  Vec3d from_a, from_b;  // m: the contact point (midway between the surfaces) from the centre of A, of B; world axes
  double separation{};   // m: signed gap along the normal; negative where the shapes overlap
  std::uint32_t feature{0};  // features that made the point: the same pair of features has the same id in every step
};

// For a pair of boxes or hulls: true if the point was made by a face of A (type 1) or B (2), false for closest points
// (0) or edges (3).
constexpr bool is_of_face(std::uint32_t feature) noexcept { return (feature >> 30) % 3 != 0; }

// Upper limit of a reported gap [m].
inline constexpr double kLargestGap = 2e-2;

// The axis of a pair in the last step: a hint that saves work, and a preference that keeps the reference face from
// alternating. Part of the state: goes on the tape.
inline constexpr std::uint8_t kFirstHullAxis = 16;

struct AxisCache {
  std::uint8_t axis{0};     // 0 none; box-box: 1..6 a face axis, 7..15 an edge axis; from kFirstHullAxis on: of hulls
  std::uint8_t a{0}, b{0};  // hulls: the face or the edge of A, of B; 0 otherwise
  friend bool operator==(const AxisCache&, const AxisCache&) = default;
};

struct Manifold {
  Vec3d normal;  // unit, from A to B
  std::uint32_t count{0};
  // For boxes and hulls that are separated: the gap along one direction, reduced by rounding. While the centres move
  // against each other by d [m] and the bodies rotate by t [rad] in all, the gap along that axis stays above gap - d -
  // lever_arm t; while this exceeds the margin there is no contact point. 0: unknown.
  double gap{}, lever_arm{};  // m
  // Of two hulls that are separated: a face of either in front of which the other is by more than the margin. Axis 0:
  // none.
  AxisCache apart;
  // False: no flat face of either body across the normal bounds the other body within kFlush (flush_seams.h), nor does
  // one while the contact is carried over. Not determined, and true, but for boxes.
  bool may_be_flush{true};
  std::array<ManifoldPoint, kMaxManifoldPoints> points;
};

// Features of the pair's points in the last step, in any order: preferred if there are more points than a manifold can
// have.
struct LastFeatures {
  std::uint32_t count{0};
  std::array<std::uint32_t, kMaxManifoldPoints> of{};

  constexpr bool has(std::uint32_t feature) const noexcept {
    for (std::uint32_t i = 0; i < count; ++i)
      if (of[i] == feature) return true;
    return false;
  }
};

// Which points of a pair are wanted.
struct ManifoldQuery {
  double margin;        // m: points up to this separation
  LastFeatures last{};  // of the last step
  // Manifold::apart of the last step, if it had no contact. It is tested first, because bodies that are near each other
  // mostly stay in front of the same face: it saves work and changes no point.
  AxisCache apart{};
};

// Returns the points whose separation is at most the margin; count 0 if there is none, or if a pose is not finite.
// Within the margin a contact is always found, and the least separation is never larger than the distance; between
// boxes and hulls it may be smaller if they are separated corner to corner.
// `hulls`: the list to which hull shapes refer; a hull with an index beyond it touches nothing.
// A plane may be A or B. Two planes never touch; meshes are handled patch by patch in collide_mesh.h, compounds part
// by part in collide_parts.h. Ties go to the
// lower feature id. The same input gives the same bits; swapping A and B gives the mirrored manifold only
// approximately, so callers pass the body with the lower id as A.
Manifold collide(PosedShape a, PosedShape b, const ManifoldQuery& query, AxisCache& cache, Hulls hulls = {}) noexcept;

}  // namespace tactus::physics
