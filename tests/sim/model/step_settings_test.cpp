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
  CHECK(global_step(small, 8, 4, true).sub_steps == 32);
  CHECK(global_step(small, 8, 4, true).tick_by_tick);
  CHECK(global_step(small, 8, 4, false).sub_steps == small.solver.global_sub_steps(8));
  CHECK_FALSE(global_step(small, 8, 4, false).tick_by_tick);
  CHECK(global_step(large, 8, 4, true).sub_steps == large.solver.global_sub_steps(8));
  CHECK_FALSE(global_step(large, 8, 4, true).tick_by_tick);
}

TEST_CASE("a small scene's global step with ghosts has a whole number of sub-steps a tick, no fewer than asked for") {
  Scene scene = scene_of(1);
  scene.solver.global_sub_steps_per_tick = 4.5;
  CHECK(global_step(scene, 8, 4, true).sub_steps == 40);
  CHECK(global_step(scene, 8, 6, true).sub_steps == 48);
  CHECK(global_step(scene, 8, 6, true).far_sub_steps == 48);
  scene.solver.far_sub_steps_per_tick = 0.5;
  CHECK(global_step(scene, 8, 6, true).far_sub_steps == 8);
  CHECK(global_step(scene, 8, 6, false).far_sub_steps == 4);
}

TEST_CASE("a step has the relax sweeps that stacks need to come to rest, whatever world takes it") {
  Scene scene = scene_of(1);
  scene.solver.contact_hertz = 1000;  // w h = 1.6
  CHECK(step_settings(scene, 1e-3, 4).relax_sweeps == 2);
  CHECK(step_settings(scene, 8e-3, 32).relax_sweeps == 2);
  CHECK(step_settings(scene, 1e-3, 8).relax_sweeps == 1);
  scene.solver.relax_sweeps = 3;
  CHECK(step_settings(scene, 1e-3, 4).relax_sweeps == 3);
}

TEST_CASE("a contact frequency is resolved from four sub-steps a period on") {
  CHECK(least_sub_steps(1, 1e-3) == 1);
  CHECK(least_sub_steps(250, 1e-3) == 1);
  CHECK(least_sub_steps(251, 1e-3) == 2);
  for (const double rate_Hz : {300.0, 1000.0, 4000.0})
    for (const unsigned sub_steps : {1u, 3u, 7u, 16u}) {  // at the limit, whatever 1 / rate rounds to
      CHECK(least_sub_steps(0.25 * sub_steps * rate_Hz, 1 / rate_Hz) == sub_steps);
      CHECK(least_sub_steps(0.2501 * sub_steps * rate_Hz, 1 / rate_Hz) == sub_steps + 1);
    }
}
