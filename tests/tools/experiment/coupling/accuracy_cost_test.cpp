#include "tools/experiment/coupling/accuracy_cost.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <nlohmann/json.hpp>

using namespace tactus;
using namespace tactus::experiment;

namespace {

CostPoint point(const std::string& scene, double error, double tick_us) {
  CostPoint point;
  point.scene = scene;
  point.force_error = error;
  point.tick_us_p50 = tick_us;
  return point;
}

const CouplingCase& case_of(const std::string& name) {
  const auto cases = coupling_cases();
  return *std::find_if(cases.begin(), cases.end(), [&](const auto& one) { return one.name == name; });
}

}  // namespace

TEST_CASE("On the front is what no other setting of its scene beats in both") {
  std::vector<CostPoint> points{point("a", 0.1, 10), point("a", 0.05, 20), point("a", 0.05, 30), point("a", 0.2, 10),
                                point("b", 0.9, 90)};
  mark_front(points);
  CHECK(points[0].on_front);
  CHECK(points[1].on_front);
  CHECK_FALSE(points[2].on_front);
  CHECK_FALSE(points[3].on_front);
  CHECK(points[4].on_front);
}

TEST_CASE("The default comes first, no setting twice, and every setting resolves its contact frequency") {
  for (const CouplingCase& one : coupling_cases()) {
    const auto scene = load_coupling_case(one, 0);
    REQUIRE(scene.ok());
    const auto settings = settings_for(scene.value(), one.members, false);
    INFO(one.name);
    CHECK(settings[0].sub_steps == scene.value().solver.sub_steps);
    CHECK(settings[0].members == one.members);
    for (std::size_t i = 0; i < settings.size(); ++i) {
      CHECK(settings[i].contact_Hz <= 0.25 * settings[i].sub_steps * 1000);
      CHECK(std::count(settings.begin(), settings.end(), settings[i]) == 1);
    }
    CHECK(settings_for(scene.value(), one.members, true).size() < settings.size());
  }
}

TEST_CASE("Accuracy has a price: more sub-steps cost more, and all that was measured is in the JSON") {
  CostRequest request;
  request.cases = {case_of("chain")};
  request.seeds = 1;
  request.quick = true;
  const auto report = run_accuracy_cost(request, {}, {});
  REQUIRE(report.ok());
  const auto json = nlohmann::json::parse(cost_json(report.value()));
  REQUIRE(json["points"].size() == settings_for(load_coupling_case(request.cases[0], 0).value(), 8, true).size());
  CHECK(json["points"][0]["is_default"] == true);
  for (const char* key :
       {"sub_steps", "relax_sweeps", "friction_sweeps", "contact_Hz", "members", "ratio", "border", "extraction",
        "world_precision", "force_error_rms", "tick_us_p50", "tick_us_p99", "instructions", "on_front"})
    CHECK(json["points"][0].contains(key));
  CHECK(std::any_of(json["points"].begin(), json["points"].end(), [](const auto& p) { return p["on_front"] == true; }));
  // One hand: what is said of it is what is said of all.
  for (const CostPoint& point : report.value().points) {
    CHECK(point.force_error_by_seed == std::vector<double>{point.force_error});
    CHECK(point.tick_us_by_seed == std::vector<double>{point.tick_us_p50});
  }
  CHECK(json["points"][0]["force_error_by_seed"].size() == 1);
  CHECK(json["period_us"] == 1000);
  CHECK(json["budget_us"] == Approx(600));  // what the governor gives to computing
  // All bodies members: no border, so that what is left is the solver's own error, below that of a border that keeps
  // the outside at rest.
  const auto whole = std::find_if(report.value().points.begin(), report.value().points.end(),
                                  [](const CostPoint& p) { return p.setting.members == 32; });
  REQUIRE(whole != report.value().points.end());
  const auto frozen = std::find_if(report.value().points.begin(), report.value().points.end(), [](const CostPoint& p) {
    return p.setting.scheme.border == physics::BorderMode::kFrozen;
  });
  REQUIRE(frozen != report.value().points.end());
  CHECK(whole->force_error < frozen->force_error);
}
