#include "rt/physics/collision/collide_cylinder.h"

#include <limits>

#include "rt/physics/collision/collide_hull.h"
#include "rt/physics/collision/simplex.h"

namespace tactus::physics {
namespace {

constexpr int kMaxRounds = 24;

bool is_round_hull(const Shape& shape) noexcept {
  return shape.kind == ShapeKind::kCylinder || shape.kind == ShapeKind::kCone;
}

// Scale of cylinders and cones in the search of the direction: bodies that touch are then apart, so that the shortest
// vector between them is not zero.
constexpr double kSmaller = 0.9;

// A convex shape without its rounding, for the search of the direction from A to B. Frame: world, origin at the centre
// of A.
struct Core {
  const Shape& shape;
  const HullView* hull;  // of a box or a hull
  Quatd rotation;
  Vec3d centre;

  // The point farthest along d.
  Vec3d support(const Vec3d& d) const noexcept {
    return centre + rotate(rotation, own_support(rotate_inverse(rotation, d)));
  }

 private:
  Vec3d own_support(const Vec3d& d) const noexcept {
    if (hull != nullptr) return hull->vertex(hull->support(d));
    if (shape.kind == ShapeKind::kSphere) return {};
    if (shape.kind == ShapeKind::kCapsule) return {0.0, 0.0, d.z < 0.0 ? -shape.half_length : shape.half_length};
    const double across = std::sqrt(d.x * d.x + d.y * d.y), r = across > 0.0 ? kSmaller * shape.radius / across : 0.0;
    const double low = kSmaller * RoundHull::lower_end(shape), high = low + kSmaller * 2.0 * shape.half_length;
    if (shape.kind == ShapeKind::kCylinder) return {r * d.x, r * d.y, d.z < 0.0 ? low : high};
    const Vec3d rim{r * d.x, r * d.y, low}, apex{0.0, 0.0, high};
    return dot(rim, d) > dot(apex, d) ? rim : apex;
  }
};

// The direction of the shortest vector from A to B; if they overlap, from centre to centre. Of any length.
// Source: Gilbert, Johnson and Keerthi 1988.
Vec3d direction_between(const Core& a, const Core& b) noexcept {
  constexpr double kProgress = 1e-12;  // of the squared distance: far above rounding
  Vec3d nearest = b.centre;
  Simplex simplex;
  for (int round = 0; round < kMaxRounds; ++round) {
    const double squared = norm_squared(nearest);
    if (!(squared > kNoDirection * kNoDirection)) return b.centre;
    const Vec3d point = b.support(-nearest) - a.support(nearest);
    if (!(squared - dot(nearest, point) > kProgress * squared)) break;
    simplex.p[simplex.count++] = point;
    nearest = nearest_of(simplex);
  }
  return nearest;
}

// A pair whose B is a cylinder or a cone; of a hull A, its view.
struct RoundPair {
  const PairView& pair;
  const HullView* hull_a;
  AxisCache& cache;

  Alignment alignment_a(const Vec3d& to_b) const noexcept {
    return Alignment::to(rotate_inverse(pair.world_from_a, to_b));
  }
  Alignment alignment_b(const Vec3d& to_b) const noexcept {
    return Alignment::to(rotate_inverse(pair.world_from_b, -to_b));
  }

  // The manifold with polygons that are turned to each other along `to_b`, world.
  Manifold collide(const Vec3d& to_b) const noexcept {
    Manifold manifold;
    const RoundHull b(pair.b, alignment_b(to_b));
    if (is_round_hull(pair.a))
      collide_hulls(pair, RoundHull(pair.a, alignment_a(to_b)).view(), b.view(), manifold, cache);
    else if (hull_a != nullptr)
      collide_hulls(pair, *hull_a, b.view(), manifold, cache);
    else if (pair.a.kind == ShapeKind::kSphere)
      collide_sphere_hull(pair, b.view(), manifold);
    else if (pair.a.kind == ShapeKind::kCapsule)
      collide_capsule_hull(pair, b.view(), manifold);
    else
      collide_plane_hull(pair, b.view(), manifold);
    return manifold;
  }

  bool is_turned(const Vec3d& before, const Vec3d& now) const noexcept {
    const auto differ = [](const Alignment& p, const Alignment& q) noexcept {
      constexpr double kSame = 1e-9;  // one less the cosine: 0.05 mrad
      return !(p.x * q.x + p.y * q.y > 1.0 - kSame);
    };
    return differ(alignment_b(before), alignment_b(now)) ||
           (is_round_hull(pair.a) && differ(alignment_a(before), alignment_a(now)));
  }
};

constexpr int kTurns = 2;

// Moves points on the facet of a round body to the facet's middle line, where the exact surface is touched. The edges
// are up to radius * kFacet beside that line: a normal force on one edge would have a moment about the axis and
// accelerate the body, forces on both edges would brake it. A contact on a cap is exact where it is: a point moved
// there would leave the line of the force. `self`: the member that is relative to that body's centre.
void centre_on_facet(const Quatd& rotation, const Alignment& alignment, double radius, Vec3d ManifoldPoint::*self,
                     Manifold& manifold) noexcept {
  if (!Alignment::faces(rotate_inverse(rotation, manifold.normal))) return;
  const Vec3d across = rotate(rotation, Vec3d{-alignment.y, alignment.x, 0.0});
  for (std::uint32_t i = 0; i < manifold.count; ++i) {
    ManifoldPoint& point = manifold.points[i];
    const double beside = dot(point.*self, across);
    if (!(std::abs(beside) <= 2.0 * radius * round_hull::kFacet)) continue;
    point.from_a -= beside * across;
    point.from_b -= beside * across;
  }
}

// Merges points that coincide now into one, with the least of their separations.
void merge_points(Manifold& manifold) noexcept {
  constexpr double kSame = 1e-7;  // m
  std::uint32_t kept = 0;
  for (std::uint32_t i = 0; i < manifold.count; ++i) {
    std::uint32_t same = 0;
    while (same < kept && norm(manifold.points[same].from_a - manifold.points[i].from_a) > kSame) ++same;
    if (same == kept)
      manifold.points[kept++] = manifold.points[i];
    else
      manifold.points[same].separation = smaller(manifold.points[same].separation, manifold.points[i].separation);
  }
  manifold.count = kept;
}

double least_separation(const Manifold& manifold) noexcept {
  double least = std::numeric_limits<double>::infinity();
  for (std::uint32_t i = 0; i < manifold.count; ++i) least = smaller(least, manifold.points[i].separation);
  return least;
}

// Collides polygons that are turned to each other: first along `to_b`, then along the normal that was found, as long as
// the separation decreases. The polygons are inside the bodies, so the result with the least separation is the most
// exact one.
// The margin is wider by `error`, because a rim may be nearer by that than its polygon that is not turned yet.
void collide_turned(const PairView& pair, const HullView* hull_a, const Vec3d& to_b, Manifold& manifold,
                    AxisCache& cache) noexcept {
  const double error =
      RoundHull::inscribed_error(pair.b) + (is_round_hull(pair.a) ? RoundHull::inscribed_error(pair.a) : 0.0);
  const PairView wider{.a = pair.a,
                       .b = pair.b,
                       .world_from_a = pair.world_from_a,
                       .world_from_b = pair.world_from_b,
                       .b_from_a = pair.b_from_a,
                       .margin = pair.margin + error,
                       .last = pair.last};
  const RoundPair round{wider, hull_a, cache};
  manifold = round.collide(to_b);
  manifold.gap -= error;
  if (manifold.count == 0) return;
  Vec3d along = to_b;
  for (int turns = 0; turns < kTurns && round.is_turned(along, manifold.normal); ++turns) {
    const Manifold turned = round.collide(manifold.normal);
    if (!(least_separation(turned) < least_separation(manifold))) break;
    along = manifold.normal;
    manifold = turned;
  }
  centre_on_facet(pair.world_from_b, round.alignment_b(along), pair.b.radius, &ManifoldPoint::from_b, manifold);
  if (is_round_hull(pair.a))
    centre_on_facet(pair.world_from_a, round.alignment_a(along), pair.a.radius, &ManifoldPoint::from_a, manifold);
  merge_points(manifold);
  drop_points_beyond(pair.margin, manifold);
}

}  // namespace

void collide_with_cylinder(const PairView& pair, Manifold& manifold, AxisCache& cache, Hulls hulls) noexcept {
  const Core b{.shape = pair.b, .hull = nullptr, .rotation = pair.world_from_b, .centre = pair.b_from_a};
  const auto collide_core = [&](const HullView* hull_a) noexcept {
    collide_turned(pair, hull_a,
                   direction_between({.shape = pair.a, .hull = hull_a, .rotation = pair.world_from_a, .centre = {}}, b),
                   manifold, cache);
  };
  switch (pair.a.kind) {
    case ShapeKind::kSphere:
    case ShapeKind::kCapsule:
    case ShapeKind::kCylinder:
    case ShapeKind::kCone:
      return collide_core(nullptr);
    case ShapeKind::kPlane:
      return collide_turned(pair, nullptr, rotate(pair.world_from_a, Vec3d{0.0, 0.0, 1.0}), manifold, cache);
    case ShapeKind::kBox: {
      const BoxHull box(pair.a.half_extents);
      const HullView hull = box.view();
      return collide_core(&hull);
    }
    case ShapeKind::kHull: {
      if (pair.a.index >= hulls.size()) return;
      const HullView hull = view_of(hulls[pair.a.index]);
      return collide_core(&hull);
    }
    case ShapeKind::kMesh:
    case ShapeKind::kCompound:
      return;
  }
}

void collide_cylinder_patch(const PatchView& patch, Manifold& manifold) noexcept {
  if (patch.triangles.empty()) return;
  const Mesh& mesh = patch.mesh;
  const Vec3d normal = mesh.patches[mesh.triangles[patch.triangles[0]].patch].normal;
  const Vec3d in_world = rotate(patch.pair.world_from_b, normal);
  const Alignment alignment = Alignment::to(rotate_inverse(patch.pair.world_from_a, -in_world));
  collide_hull_patch(patch, RoundHull(patch.pair.a, alignment).view(), manifold);
  centre_on_facet(patch.pair.world_from_a, alignment, patch.pair.a.radius, &ManifoldPoint::from_a, manifold);
  merge_points(manifold);
}

}  // namespace tactus::physics
