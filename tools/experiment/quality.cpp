#include "tools/experiment/quality.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "rt/physics/collision/fixed_tree.h"

namespace tactus::experiment {
namespace {

std::vector<Posed> poses_of(const std::vector<CubeState>& cubes) {
  std::vector<Posed> poses;
  poses.reserve(cubes.size());
  for (const CubeState& cube : cubes) poses.push_back({cube.position, cube.rotation});
  return poses;
}

double mean_distance(const std::vector<Posed>& from, const std::vector<Posed>& to) {
  double sum = 0;
  for (std::size_t i = 0; i < to.size(); ++i) sum += norm(to[i].position - from[i].position);
  return to.empty() ? 0 : sum / static_cast<double>(to.size());
}

}  // namespace

QualitySampler::QualitySampler(const BoxScene& scene)
    : judge_(scene), walls_(scene.walls), escaped_(scene.cubes.size()) {
  const auto bounds = [](const Wall& wall) {
    return physics::bounds_of(physics::Shape::box(wall.half_extents_m), Posed{wall.position, wall.rotation}, 0.0);
  };
  if (!walls_.empty()) all_walls_ = bounds(walls_.front());
  for (const Wall& wall : walls_) all_walls_ = physics::join(all_walls_, bounds(wall));
}

bool QualitySampler::is_outside(const Vec3d& centre) const noexcept {
  if (!walls_.empty() && !all_walls_.overlaps({centre, centre})) return true;
  return std::any_of(walls_.begin(), walls_.end(), [&](const Wall& wall) {
    const Vec3d in_wall = rotate_inverse(wall.rotation, centre - wall.position), &half = wall.half_extents_m;
    return std::abs(in_wall.x) < half.x && std::abs(in_wall.y) < half.y && std::abs(in_wall.z) < half.z;
  });
}

void QualitySampler::start(const Engine& engine) {
  last_ = poses_of(engine.cubes());
  last_rods_ = engine.rods();
  runs_ += 1;
}

void QualitySampler::sample(const Engine& engine) {
  const std::vector<Posed> bodies = poses_of(engine.cubes()), rods = engine.rods();
  const Overlaps overlaps = judge_.judge(bodies, rods);
  sum_.overlap_mean_m += overlaps.mean_m;
  sum_.overlap_mean_share += overlaps.mean_share;
  sum_.overlap_max_m = std::max(sum_.overlap_max_m, overlaps.deepest_m);
  sum_.overlap_max_share = std::max(sum_.overlap_max_share, overlaps.deepest_share);
  sum_.complete = sum_.complete && overlaps.complete;
  sum_.travel_m += mean_distance(last_, bodies);
  sum_.rod_travel_m += mean_distance(last_rods_, rods);
  for (std::size_t i = 0; i < bodies.size(); ++i)
    if (is_outside(bodies[i].position)) escaped_[i] = 1;
  last_ = bodies;
  last_rods_ = rods;
  samples_ += 1;
}

Quality QualitySampler::result() const {
  Quality quality = sum_;
  if (samples_ > 0) {
    quality.overlap_mean_m /= samples_;
    quality.overlap_mean_share /= samples_;
  }
  if (runs_ > 0) {
    quality.travel_m /= runs_;
    quality.rod_travel_m /= runs_;
  }
  quality.escaped = static_cast<std::uint32_t>(std::count(escaped_.begin(), escaped_.end(), 1));
  return quality;
}

std::string missed_gate(const Quality& quality) {
  if (!quality.complete) return "a pose is not finite, or more bodies meet than can be judged";
  if (quality.escaped > 0)
    return fmt::format("bodies that went through the floor or a wall or flew off: {}", quality.escaped);
  if (!(quality.overlap_max_share <= kMaxOverlapShare))
    return fmt::format("the deepest overlap is {:.0f} % of a body's thickness, {:.0f} % at most",
                       100 * quality.overlap_max_share, 100 * kMaxOverlapShare);
  if (!(quality.overlap_mean_share <= kMaxMeanOverlapShare))
    return fmt::format("the mean overlap is {:.1f} % of a body's thickness, {:.0f} % at most",
                       100 * quality.overlap_mean_share, 100 * kMaxMeanOverlapShare);
  if (quality.travel_m < kMinTravelShare * quality.rod_travel_m)
    return fmt::format("what is stirred travels {:.3g} m while the rods travel {:.3g} m, {:.0f} % at least",
                       quality.travel_m, quality.rod_travel_m, 100 * kMinTravelShare);
  return {};
}

}  // namespace tactus::experiment
