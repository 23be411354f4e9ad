#include "tools/experiment/peers.h"

#include <catch2/catch.hpp>

#include <nlohmann/json.hpp>

#include "tools/experiment/allocation_count.h"
#include "tools/experiment/scaling.h"

using namespace tactus::experiment;

namespace {

PeersRequest tiny_request() {
  PeersRequest request;
  BoxScene scene = make_pile("tiny", {.cubes = 8, .step_s = 1e-2, .layers = 2});
  scene.settle_s = 2, scene.timed_steps = 20;
  request.scenes.push_back(scene);
  request.engines.push_back(engine_kinds().front());
  request.runs = 2;
  return request;
}

}  // namespace

TEST_CASE("A settled tiny pile rests, touches, and tactus allocates nothing in a step") {
  const auto rows = run_peers(tiny_request(), {});
  REQUIRE(rows.size() == 1);
  const PeersRow& row = rows.front();
  CHECK(row.scene == "tiny");
  CHECK(row.engine == "tactus");
  CHECK(row.failure.empty());
  CHECK(row.touching_pairs >= 8);  // each cube stands on something
  CHECK(row.contacts >= row.touching_pairs);
  CHECK(row.residual_speed_rms_m_per_s < 1e-2);
  CHECK(row.penetration_max_m < 1e-3);
  CHECK(row.allocations_per_step == 0);
  CHECK(row.worst_over_median >= 1);
  CHECK(row.p99_us >= row.median_us);
  CHECK(row.ratio_to_bullet == 0);  // it did not run
}

TEST_CASE("The rows have the keys that readers rely on") {
  PeersRow row;
  row.scene = "pile64", row.engine = "bullet", row.median_us = 12.5, row.ratio_to_bullet = 1;
  const auto json = nlohmann::json::parse(peers_json({row}));
  REQUIRE(json.at("rows").size() == 1);
  const auto& first = json.at("rows").at(0);
  for (const char* key : {"scene", "engine", "median_us", "p99_us", "worst_over_median", "contacts", "touching_pairs",
                          "residual_speed_rms_m_per_s", "penetration_max_m", "allocations_per_step", "ratio_to_bullet"})
    CHECK(first.contains(key));
  CHECK(first.at("median_us") == 12.5);
  CHECK(first.at("ratio_to_bullet") == 1);
}

TEST_CASE("An allocation is counted") {
  if (!allocations_are_counted()) return;
  const auto before = allocation_count();
  auto* volatile number = new int(1);
  delete number;
  CHECK(allocation_count() == before + 1);
}

TEST_CASE("A world whose capacity is short says so") {
  // 64 cubes in one place are 2016 pairs; 16 for each of them are fewer.
  BoxScene scene = make_pile("crowd", {.cubes = 64, .step_s = 1e-2});
  for (Cube& cube : scene.cubes) cube.position = {0, 0, 1};
  const auto engine = make_tactus(scene, {});
  engine->step();
  CHECK(engine->failure().find("capacity") != std::string::npos);
}

TEST_CASE("The scaling report has a row for each case, units in its header and a plot") {
  const std::vector<ScalingCase> cases{{"bodies", {.cubes = 8, .step_s = 1e-2, .layers = 2}, 4, 0.5, 5},
                                       {"bodies", {.cubes = 27, .step_s = 1e-2, .layers = 3}, 4, 0.5, 5}};
  const auto report = run_scaling(cases, {}, "", true, {});
  REQUIRE(report.rows.size() == 2);
  CHECK(report.rows[1].contact_points > report.rows[0].contact_points);
  const std::string csv = scaling_csv(report);
  CHECK(csv.find("median [us]") != std::string::npos);
  CHECK(std::count(csv.begin(), csv.end(), '\n') == 3);
  CHECK(nlohmann::json::parse(scaling_json(report)).at("rows").size() == 2);
  CHECK(scaling_svg(report).find("<circle") != std::string::npos);
}
