#include "sim/model/step_settings.h"

#include <catch2/catch.hpp>

using namespace tactus;
using namespace tactus::sim;
using physics::SweepPrecision;

namespace {

Scene scene_of(std::size_t moving) {
  Scene scene;
  scene.bodies.resize(moving + 1);
  scene.bodies[0].kind = physics::BodyKind::kFixed;
  for (std::size_t i = 1; i <= moving; ++i) scene.bodies[i].kind = physics::BodyKind::kDynamic;
  return scene;
}

}  // namespace

TEST_CASE("a small scene's global step is in double, and with ghosts as fine as the ticks") {
  const Scene small = scene_of(kMaxBodiesInFineSteps), large = scene_of(kMaxBodiesInFineSteps + 1);
  CHECK(sweep_precision(small, SweepPrecision::kSingle) == SweepPrecision::kFull);
  CHECK(sweep_precision(small, SweepPrecision::kFull) == SweepPrecision::kFull);
  CHECK(sweep_precision(large, SweepPrecision::kSingle) == SweepPrecision::kSingle);
  CHECK(sweep_precision(large, SweepPrecision::kFull) == SweepPrecision::kFull);
  CHECK(global_sub_steps(small, 8, 4, true) == 32);
  CHECK(global_sub_steps(small, 8, 4, false) == small.solver.global_sub_steps(8));
  CHECK(global_sub_steps(large, 8, 4, true) == large.solver.global_sub_steps(8));
}
