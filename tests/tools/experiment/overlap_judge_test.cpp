#include "tools/experiment/overlap_judge.h"

#include <catch2/catch.hpp>

#include <limits>

using namespace tactus;
using namespace tactus::experiment;

namespace {

constexpr double kEdge_m = 0.1;

// Three cubes above a floor, far apart.
BoxScene three_cubes() {
  BoxScene scene;
  for (const double x : {-1.0, 0.0, 1.0}) scene.cubes.push_back({kEdge_m, 1, {x, 0, 0.5}, {}});
  scene.walls.push_back({{2, 2, 0.5}, {0, 0, -0.5}});
  return scene;
}

std::vector<Posed> poses_of(const BoxScene& scene) {
  std::vector<Posed> poses;
  for (const Cube& cube : scene.cubes) poses.push_back({cube.position, cube.rotation});
  return poses;
}

}  // namespace

TEST_CASE("What touches nothing overlaps nothing") {
  const BoxScene scene = three_cubes();
  OverlapJudge judge(scene);
  const Overlaps overlaps = judge.judge(poses_of(scene), {});
  CHECK(overlaps.complete);
  CHECK(overlaps.deepest_m == 0);
  CHECK(overlaps.mean_share == 0);
}

TEST_CASE("Overlaps are as deep as the bodies lie in each other, in the mean over all bodies") {
  const BoxScene scene = three_cubes();
  OverlapJudge judge(scene);
  auto poses = poses_of(scene);
  poses[0].position = {0.5 * kEdge_m, 0.5 * kEdge_m, 0.5 + kEdge_m - 0.004};  // 4 mm in the second
  poses[2].position.z = 0.5 * kEdge_m - 0.01;                                 // 10 mm in the floor
  const Overlaps overlaps = judge.judge(poses, {});
  CHECK(overlaps.deepest_m == Approx(0.01));
  CHECK(overlaps.deepest_share == Approx(0.1));
  CHECK(overlaps.mean_m == Approx((0.004 + 0.004 + 0.01) / 3));
  CHECK(overlaps.mean_share == Approx(0.18 / 3));
}

TEST_CASE("A share is of the thinner body, the rods count and their depth in the floor does not") {
  BoxScene scene = three_cubes();
  scene.stirrer = make_stirrer(3, kEdge_m);
  REQUIRE(rods_of(scene) == 1);
  OverlapJudge judge(scene);
  auto poses = poses_of(scene);
  const Posed rod = scene.stirrer->pose_at(0, 0);
  CHECK(judge.judge(poses, std::vector{rod}).deepest_m == 0);
  const double thin = scene.stirrer->half_extents_m.x;
  poses[1].position = rod.position + Vec3d{thin + 0.5 * kEdge_m - 0.005, 0, 0};
  const Overlaps overlaps = judge.judge(poses, std::vector{rod});
  CHECK(overlaps.deepest_m == Approx(0.005));
  CHECK(overlaps.deepest_share == Approx(0.005 / (2 * thin)));
  CHECK(overlaps.mean_m == Approx(0.005 / 3));
}

TEST_CASE("A pose that is not finite is reported") {
  const BoxScene scene = three_cubes();
  OverlapJudge judge(scene);
  auto poses = poses_of(scene);
  poses[1].position.x = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(judge.judge(poses, {}).complete);
}
