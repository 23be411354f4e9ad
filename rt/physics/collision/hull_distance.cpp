#include "rt/physics/collision/hull_distance.h"

#include "rt/physics/collision/simplex.h"

namespace tactus::physics {
namespace {

constexpr int kMaxRounds = 24;

}  // namespace

HullSeparation gap_of(const RelativeHulls& hulls, double margin) noexcept {
  // Relative progress below which the distance is known well enough: far above rounding.
  constexpr double kProgress = 1e-10;
  Vec3d nearest = hulls.centre;  // the centres are in the hulls
  Simplex simplex;
  for (int round = 0; round < kMaxRounds; ++round) {
    const double squared = norm_squared(nearest);
    if (!(squared > margin * margin)) return {};
    const Vec3d point = hulls.other_vertex(hulls.other.support(hulls.to_other(-nearest))) -
                        hulls.ref.vertex(hulls.ref.support(nearest));
    const double along = dot(nearest, point);
    if (along > 0.0 && along * along > margin * margin * squared) return {true, along / std::sqrt(squared), nearest};
    if (!(squared - along > kProgress * squared)) return {};
    simplex.p[simplex.count++] = point;
    nearest = nearest_of(simplex);
  }
  return {};
}

}  // namespace tactus::physics
