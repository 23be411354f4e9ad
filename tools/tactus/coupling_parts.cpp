#include "tools/tactus/coupling_parts.h"

#include <algorithm>

#include "tools/experiment/coupling/study_fields.h"
#include "tools/experiment/coupling/whole_run.h"
#include "tools/tactus/coupling_options.h"
#include "tools/tactus/experiment_parts.h"

namespace tactus::tools {
namespace {

std::vector<unsigned> caps_of(const CouplingOptions& options) {
  return options.members.empty() ? std::vector<unsigned>{0} : options.members;
}

std::vector<experiment::WholeRunHand> hands_of(const CouplingOptions& options) {
  using enum experiment::WholeRunHand;
  if (options.hands.empty() && options.output.quick) return {kClosed};
  if (options.hands.empty()) return {kClosed, kDirect};
  std::vector<experiment::WholeRunHand> hands;
  for (const auto hand : {kClosed, kDirect, kNone})
    if (std::find(options.hands.begin(), options.hands.end(), experiment::name_of(hand)) != options.hands.end())
      hands.push_back(hand);
  return hands;
}

// Adds the rows of other scenes, of another cap, or of whole runs; the properties of a scene are those of the last cap.
void add(const experiment::StudyReport& part, experiment::StudyReport& all) {
  all.rows.insert(all.rows.end(), part.rows.begin(), part.rows.end());
  all.whole.insert(all.whole.end(), part.whole.begin(), part.whole.end());
  for (const auto& scene : part.scenes) {
    std::erase_if(all.scenes, [&](const auto& other) { return other.name == scene.name; });
    all.scenes.push_back(scene);
  }
  if (part.rows.empty()) return;
  all.seeds = part.seeds;
  all.windows = part.windows;
  all.window_s = part.window_s;
  all.line_Hz = part.line_Hz;
}

// `floor`: with the direct run that starts apart, for each scene.
Result<experiment::StudyReport> run_whole_runs(const CouplingOptions& options, const experiment::StudyRequest& study,
                                               std::vector<unsigned> caps, bool floor) {
  experiment::WholeRunRequest request;
  for (const auto& one : study.cases) {
    auto scene = experiment::load_case_scene(one);
    if (!scene.ok()) return scene.status();
    request.scenes.push_back(std::move(scene).value());
    request.scenes.back().members = one.members;
  }
  for (const auto& scheme : study.schemes)
    if (!scheme.direct()) request.schemes.push_back(scheme);
  request.members = std::move(caps);
  request.seconds = options.whole_s;
  request.hands = hands_of(options);
  request.floor = floor && request.hands.front() != experiment::WholeRunHand::kNone;
  request.order = study.order;
  auto rows = experiment::run_whole(request, experiment::terminal_progress());
  if (!rows.ok()) return rows.status();
  experiment::StudyReport report;
  report.whole = std::move(rows).value();
  return report;
}

std::size_t windows_parts(const CouplingOptions& options, const experiment::StudyRequest& request) {
  return request.seeds > 0 ? caps_of(options).size() * request.cases.size() : 0;
}

}  // namespace

std::size_t coupling_parts(const CouplingOptions& options, const experiment::StudyRequest& request) {
  return windows_parts(options, request) + (options.whole_s > 0 ? caps_of(options).size() * request.cases.size() : 0);
}

Result<experiment::StudyReport> run_coupling_part(const CouplingOptions& options, experiment::StudyRequest request,
                                                  std::size_t part) {
  const auto caps = caps_of(options);
  const std::size_t first_whole = windows_parts(options, request), cases = request.cases.size();
  if (part < first_whole) {  // cap by cap, all scenes
    request.members = caps[part / cases];
    request.cases = {request.cases[part % cases]};
    return experiment::run_coupling_study(request, experiment::terminal_progress());
  }
  const std::size_t k = part - first_whole, cap = k % caps.size();  // scene by scene, all caps
  request.cases = {request.cases[k / caps.size()]};
  return run_whole_runs(options, request, {caps[cap]}, cap == 0);
}

Result<experiment::StudyReport> run_couplings_elsewhere(const CouplingOptions& options,
                                                        const experiment::StudyRequest& request,
                                                        const std::vector<std::string>& arguments) {
  const auto parts = parts_of<experiment::StudyReport>(options.parts, {.arguments = arguments,
                                                                       .count = coupling_parts(options, request),
                                                                       .scenes = experiment::files_of(request.cases)});
  if (!parts.ok()) return parts.status();
  experiment::StudyReport all;
  for (const auto& part : parts.value()) add(part, all);
  return all;
}

Result<experiment::StudyReport> run_couplings_here(const CouplingOptions& options, experiment::StudyRequest request) {
  experiment::StudyReport all;
  for (const unsigned members : caps_of(options)) {
    if (request.seeds == 0) break;
    request.members = members;
    const auto windows = experiment::run_coupling_study(request, experiment::terminal_progress());
    if (!windows.ok()) return windows.status();
    add(windows.value(), all);
  }
  if (options.whole_s > 0) {
    const auto whole = run_whole_runs(options, request, caps_of(options), true);
    if (!whole.ok()) return whole.status();
    add(whole.value(), all);
  }
  return all;
}

}  // namespace tactus::tools
