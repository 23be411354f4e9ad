#include "tools/experiment/stirrer.h"

#include <algorithm>
#include <cmath>

namespace tactus::experiment {
namespace {

// All lengths in edges of the largest body.
constexpr double kBodiesPerRod = 50;
constexpr double kHalfThickness = 0.25, kHeight = 4, kDepthInFloor = 0.1;
constexpr double kPitch = 4.2, kRadius = 1.1;
constexpr double kSpeed_rad_per_s = 2;
constexpr double kRoomAtWall = 0.5;  // free width between wall and rods, on the floor

}  // namespace

Posed Stirrer::pose_at(std::size_t rod, double time_s) const noexcept {
  const double angle = speed_rad_per_s * time_s;
  return {centres_m[rod] + radius_m * Vec3d{std::cos(angle), std::sin(angle), 0}, {}};
}

Twistd Stirrer::velocity_at(double time_s) const noexcept {
  const double angle = speed_rad_per_s * time_s, speed = radius_m * speed_rad_per_s;
  return {{-speed * std::sin(angle), speed * std::cos(angle), 0}, {}};
}

Twistd Stirrer::velocity_over(std::size_t rod, const Vec3d& position, double time_s, double step_s) const noexcept {
  return {(1 / step_s) * (pose_at(rod, time_s + step_s).position - position), {}};
}

double Stirrer::path_length_m(double duration_s) const noexcept { return radius_m * speed_rad_per_s * duration_s; }

Stirrer make_stirrer(std::uint32_t bodies, double edge_m) {
  Stirrer stirrer;
  const double half_height = 0.5 * (kHeight + kDepthInFloor) * edge_m;
  stirrer.half_extents_m = {kHalfThickness * edge_m, kHalfThickness * edge_m, half_height};
  stirrer.radius_m = kRadius * edge_m;
  stirrer.speed_rad_per_s = kSpeed_rad_per_s;
  const auto side = static_cast<std::uint32_t>(std::max(1L, std::lround(std::sqrt(bodies / kBodiesPerRod))));
  const double pitch = kPitch * edge_m, first = -0.5 * pitch * (side - 1);
  for (std::uint32_t y = 0; y < side; ++y)
    for (std::uint32_t x = 0; x < side; ++x)
      stirrer.centres_m.push_back({first + pitch * x, first + pitch * y, half_height - kDepthInFloor * edge_m});
  return stirrer;
}

double floor_width(const Stirrer& stirrer, double edge_m) noexcept {
  double outermost = 0;
  for (const Vec3d& centre : stirrer.centres_m) outermost = std::max(outermost, centre.x);
  return 2 * (outermost + stirrer.radius_m + stirrer.half_extents_m.x + kRoomAtWall * edge_m);
}

}  // namespace tactus::experiment
