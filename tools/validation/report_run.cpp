#include <fmt/format.h>

#include <algorithm>

#include "tools/validation/report.h"

namespace tactus::hard_cases {
namespace {

experiment::BoxScene scene_of(const StackSpec& spec, double step_s) {
  experiment::BoxScene scene;
  scene.name = spec.name;
  scene.step_s = step_s;
  scene.friction = spec.friction;
  for (std::size_t k = 0; k < spec.masses_kg.size(); ++k)
    scene.cubes.push_back(
        {.edge_m = spec.edge_m, .mass_kg = spec.masses_kg[k], .position = spec.start_of(k), .rotation = {}});
  scene.walls.push_back({{2, 2, 0.5}, {0, 0, -0.5}});
  return scene;
}

PeerRow run_peer(const StackSpec& spec, const experiment::EngineKind& kind, double step_s) {
  experiment::EngineOptions options;
  options.tuned = kind.tuned;
  const auto engine = kind.make(scene_of(spec, step_s), options);
  for (auto steps = static_cast<long>(spec.seconds / step_s + 0.5); steps > 0; --steps) engine->step();
  std::vector<Vec3d> centres;
  for (const auto& cube : engine->cubes()) centres.push_back(cube.position);
  return {.stack = spec.name, .engine = std::string(kind.name), .step_s = step_s, .state = judge(spec, centres)};
}

}  // namespace

bool Report::all_pass_at(Accuracy accuracy) const noexcept {
  return std::all_of(rows.begin(), rows.end(),
                     [accuracy](const Row& row) { return row.setting.accuracy != accuracy || row.outcome.passed(); });
}

Report run(const Request& request, const experiment::Progress& progress) {
  Report report;
  for (const HardCase* one : request.cases)
    for (const double step_s : request.steps_s)
      for (const Accuracy accuracy : request.accuracies) {
        if (step_s > 5e-3 && !one->global_step) continue;
        if (progress)
          progress(fmt::format("{} {}, {}, {:g} ms", one->number, one->name, name_of(accuracy), 1e3 * step_s));
        Row row{one, {accuracy, step_s}, {}};
        row.outcome = run_twice(*one, row.setting);
        report.rows.push_back(std::move(row));
      }
  for (const StackSpec& spec : request.peers.empty() ? std::vector<StackSpec>{} : compared_stacks()) {
    for (const double step_s : request.steps_s)
      report.peers.push_back(
          {.stack = spec.name, .engine = "tactus", .step_s = step_s, .state = stack_in_tactus(spec, step_s)});
    for (const auto& kind : request.peers)
      for (const double step_s : request.steps_s) {
        if (progress) progress(fmt::format("{}, {}, {:g} ms", spec.name, kind.name, 1e3 * step_s));
        report.peers.push_back(run_peer(spec, kind, step_s));
      }
  }
  return report;
}

}  // namespace tactus::hard_cases
