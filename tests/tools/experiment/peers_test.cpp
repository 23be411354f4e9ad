#include "tools/experiment/peers.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/support/run_command.h"
#include "tests/support/skip.h"
#include "tools/experiment/allocation_count.h"
#include "tools/experiment/page.h"
#include "tools/experiment/scaling.h"
#include "tools/version/provenance.h"

using namespace tactus::experiment;

namespace {

PeersRequest tiny_request() {
  PeersRequest request;
  BoxScene scene = make_pile("tiny", {.cubes = 8, .step_s = 1e-2, .layers = 2});
  scene.settle_s = 2;
  scene.timed_steps = 20;
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
  CHECK(row.quality.overlap_max_m < 1e-3);
  CHECK(row.quality.overlap_mean_m <= row.quality.overlap_max_m);
  CHECK(row.quality.escaped == 0);
  CHECK(row.is_compared());
  CHECK(row.allocations_per_step == 0);
  CHECK(row.worst_over_median >= 1);
  CHECK(row.p99_us >= row.median_us);
  CHECK(row.ratio_to_bullet == 0);  // it did not run
  CHECK(row.ratio_to_best_peer == 0);
}

TEST_CASE("A scene is given to the engines that take it") {
  PeersRequest request = tiny_request();
  request.engines.push_back(request.engines.front());
  request.engines.back().name = "picky";
  request.engines.back().takes = [](const BoxScene& scene) { return scene.cubes.size() > 8; };
  CHECK(run_peers(request, {}).size() == 1);
  request.scenes.push_back(make_pile("tiny too", {.cubes = 9, .step_s = 1e-2, .layers = 2}));
  request.scenes.back().settle_s = 0.1;
  request.scenes.back().timed_steps = 20;
  const auto rows = run_peers(request, {});
  REQUIRE(rows.size() == 3);
  CHECK(rows[0].scene == "tiny");
  CHECK(rows[2].scene == "tiny too");
  CHECK(rows[2].engine == "picky");
}

TEST_CASE("Boxes slide over flat and ridged triangles as far as the formula says") {
  const SlideError error = slide_error(engine_kinds().front(), {});
  INFO(error.ground);
  CHECK(error.share < 0.015);  // the formula is for steps of 10 ms, tactus takes sub-steps: 0.9 %
}

TEST_CASE("The judge of a slide sees boxes that stay where they are, and work that was left out") {
  struct Stuck final : Engine {
    explicit Stuck(const BoxScene& scene) {
      for (const Cube& cube : scene.cubes) at.push_back({cube.position, {}, cube.rotation});
    }
    void step() override {}
    Measurement measure() override { return {}; }
    std::vector<CubeState> cubes() const override { return at; }
    std::vector<tactus::Posed> rods() const override { return {}; }
    std::string settings() const override { return {}; }
    std::string failure() const override { return left_out ? "left out" : ""; }
    std::vector<CubeState> at;
    bool left_out{false};
  };
  EngineKind kind = engine_kinds().front();
  kind.make = [](const BoxScene& scene, const EngineOptions&) -> std::unique_ptr<Engine> {
    return std::make_unique<Stuck>(scene);
  };
  CHECK(slide_error(kind, {}).share == Approx(1));
  kind.make = [](const BoxScene& scene, const EngineOptions&) -> std::unique_ptr<Engine> {
    auto engine = std::make_unique<Stuck>(scene);
    engine->left_out = true;
    return engine;
  };
  CHECK(std::isinf(slide_error(kind, {}).share));
}

TEST_CASE("A row that misses a gate is not compared, and nothing is compared with it") {
  const auto row_of = [](const char* engine, double median_us) {
    PeersRow row;
    row.engine = engine;
    row.median_us = median_us;
    return row;
  };
  std::vector<PeersRow> rows{row_of("tactus", 10), row_of("bullet", 100), row_of("bullet-tuned", 50),
                             row_of("ode", 20)};
  rows[3].missed_gate = "the deepest overlap";
  compare(rows);
  CHECK(rows[0].ratio_to_bullet == Approx(0.1));
  CHECK(rows[0].ratio_to_best_peer == Approx(0.2));
  CHECK(rows[2].ratio_to_best_peer == Approx(1));
  CHECK(rows[3].ratio_to_bullet == 0);
  rows[1].missed_gate = "the deepest overlap";
  rows[0].ratio_to_bullet = 0;
  compare(rows);
  CHECK(rows[0].ratio_to_bullet == 0);
  rows[0].failure = "work was left out";
  rows[0].ratio_to_best_peer = 0;
  compare(rows);
  CHECK(rows[0].ratio_to_best_peer == 0);
}

TEST_CASE("Each gate is missed by what it is for") {
  Quality good;
  good.overlap_max_share = 0.24;
  good.overlap_mean_share = 0.019;
  good.travel_m = 0.06;
  good.rod_travel_m = 1;
  CHECK(missed_gate(good).empty());
  Quality deep = good, mean = good, gone = good, still = good, broken = good;
  deep.overlap_max_share = 0.26;
  mean.overlap_mean_share = 0.021;
  gone.escaped = 1;
  still.travel_m = 0.04;
  broken.complete = false;
  for (const Quality& one : {deep, mean, gone, still, broken}) CHECK_FALSE(missed_gate(one).empty());
}

TEST_CASE("The rows have the keys that readers rely on") {
  PeersRow row;
  row.scene = "pile64";
  row.engine = "bullet";
  row.median_us = 12.5;
  row.ratio_to_bullet = 1;
  const auto json = nlohmann::json::parse(peers_json({row}));
  REQUIRE(json.at("rows").size() == 1);
  const auto& first = json.at("rows").at(0);
  for (const char* key : {"scene", "engine", "median_us", "p99_us", "worst_over_median", "contacts", "touching_pairs",
                          "residual_speed_rms_m_per_s", "penetration_max_m", "allocations_per_step", "ratio_to_bullet",
                          "ratio_to_best_peer", "penetration_mean_m", "penetration_max_share", "travel_m", "escaped",
                          "is_compared", "settings", "missed_gate"})
    CHECK(first.contains(key));
  CHECK(first.at("median_us") == 12.5);
  CHECK(first.at("ratio_to_bullet") == 1);
  CHECK(first.at("ratio_to_best_peer").is_null());
  const std::string csv = peers_csv({row});
  CHECK(csv.find("overlap_mean [m]") != std::string::npos);
  CHECK(std::count(csv.begin(), csv.end(), '\n') == 2);
  const std::string table = peers_table({row});
  for (const char* head : {"mean mm", "deep mm", "travel m", "gates"}) CHECK(table.find(head) != std::string::npos);
}

TEST_CASE("The page of the rows is one file, or says what it needs") {
  PeersRow row;
  row.scene = "pile64-stirred";
  row.engine = "tactus";
  row.median_us = 12.5;
  row.ratio_to_best_peer = 0.5;
  row.quality.overlap_mean_share = 0.001;
  PeersRow peer = row;
  peer.engine = "bullet";
  peer.missed_gate = "the deepest overlap";
  const std::string path = (std::filesystem::temp_directory_path() / "tactus_peers_page_test.html").string();
  const auto status = write_page("peers", peers_json({row, peer}), "tactus experiment peers", path);
  if (!status.ok()) REQUIRE(status.message().find("matplotlib") != std::string::npos);
  TACTUS_NEEDS(status.ok(), "a page needs Python's matplotlib");
  std::ifstream in(path);
  const std::string page((std::istreambuf_iterator<char>(in)), {});
  std::filesystem::remove(path);
  CHECK(page.find("the deepest overlap") != std::string::npos);
  CHECK(page.find("<svg") != std::string::npos);
  const tactus::Provenance made = tactus::provenance("tactus experiment peers");
  for (const std::string& words : {made.version, made.built_for, made.command})
    CHECK(page.find(words) != std::string::npos);
  const auto refused =
      write_page("peers", peers_json({row, peer}), "tactus experiment peers", "/nonexistent/page.html");
  CHECK(refused.message() == "--page: /nonexistent/page.html: cannot be written");
  const auto failed = write_page("peers", "{}", "tactus experiment peers", path);
  CHECK(failed.message().find("failed, as it says above") != std::string::npos);
}

TEST_CASE("An allocation is counted") {
  TACTUS_NEEDS(allocations_are_counted(), "counting allocations needs a build without a sanitizer");
  const auto before = allocation_count();
  auto* volatile number = new int(1);
  delete number;
  CHECK(allocation_count() == before + 1);
}

TEST_CASE("The program has no malloc of its own: a user's heap profiler sees what it allocates") {
  const std::string symbols = tactus::test::run_command("nm --defined-only " TACTUS_PROGRAM " 2>/dev/null").out;
  REQUIRE(symbols.find(" main\n") != std::string::npos);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__clang__)  // a sanitizer has one
  for (const char* name : {" malloc\n", " calloc\n", " realloc\n", " free\n"})
    CHECK(symbols.find(name) == std::string::npos);
#endif
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
  const std::string svg = scaling_svg(report);
  CHECK_THAT(svg,
             Catch::Contains("<polyline") && Catch::Contains("contact points [1]") && Catch::Contains("[\u00b5s]"));
  std::size_t marks = 0;
  for (std::size_t at = 0; (at = svg.find("<circle", at)) != std::string::npos; ++at) ++marks;
  CHECK(marks == 2);
}
