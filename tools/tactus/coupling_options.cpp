#include "tools/tactus/coupling_options.h"

#include <fmt/format.h>

#include <algorithm>

#include "sim/model/choice_names.h"
#include "tools/tactus/commands.h"
#include "tools/tactus/experiments.h"

namespace tactus::tools {
namespace {

std::vector<std::string> case_names() {
  std::vector<std::string> names;
  for (const auto& one : experiment::coupling_cases()) names.push_back(one.name);
  return names;
}

// The command line that gives the same figures.
std::string command_of(const CouplingOptions& o, const experiment::StudyRequest& request) {
  std::string text = "tactus experiment " + o.name;
  if (!o.scenes.empty()) text += fmt::format(" --scenes {}", fmt::join(o.scenes, ","));
  if (!o.borders.empty()) text += fmt::format(" --borders {}", fmt::join(o.borders, ","));
  if (!o.ratios.empty()) text += fmt::format(" --ratios {}", fmt::join(o.ratios, ","));
  text += fmt::format(" --seeds {}", request.seeds);
  for (const std::string& file : o.scene_files) text += " --scene " + file;
  if (o.whole_s > 0) text += fmt::format(" --whole {:g}", o.whole_s);
  if (!o.members.empty()) text += fmt::format(" --members {}", fmt::join(o.members, ","));
  if (o.order != "best-first") text += " --order " + o.order;
  return text + (o.output.quick ? " --quick" : "");
}

}  // namespace

void add_coupling_options(CLI::App& command, CouplingOptions& options) {
  options.name = command.get_name();
  command.add_option("--scenes", options.scenes, "scenes, separated by commas; all by default")
      ->delimiter(',')
      ->check(CLI::IsMember(case_names()));
  command.add_option("--scene", options.scene_files, "any scene file instead, with its own hand; may be given again")
      ->check(CLI::ExistingFile);
  command
      .add_option("--whole", options.whole_s,
                  "also whole runs of so many seconds, from rest, with the hand of the scene's own script")
      ->check(CLI::Range(1.0, 600.0));
  command.add_option("--borders", options.borders, "borders, separated by commas; all that are compared by default")
      ->delimiter(',')
      ->check(CLI::IsMember(sim::border_names()));
  command.add_option("--ratios", options.ratios, "ticks per global step, separated by commas; default 1,2,4,8,16")
      ->delimiter(',')
      ->check(CLI::Range(1, 100));
  command.add_option("--seeds", options.seeds, "hands that press and slide a little differently")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  command
      .add_option("--members", options.members,
                  "caps of the sub-world, separated by commas; default: what the scene's case says")
      ->delimiter(',')
      ->check(CLI::Range(1, 256));
  command.add_option("--order", options.order, "in which the contact graph is cut: best-first or breadth-first")
      ->check(CLI::IsMember({"best-first", "breadth-first"}))
      ->capture_default_str();
  options.output.add_csv(command, "writes the rows to this file, units in the header");
  options.output.add_page(command, "them");
  options.output.add_quick(command, "about a minute: two seeds, two windows each, ratios 2, 8 and 16");
  options.output.add_json(command);
}

namespace {

Result<std::vector<experiment::CouplingCase>> cases_of(const CouplingOptions& options) {
  std::vector<experiment::CouplingCase> cases;
  for (const std::string& file : options.scene_files) {
    auto one = experiment::case_of_file(file);
    if (!one.ok()) return one.status();
    cases.push_back(std::move(one).value());
  }
  if (!cases.empty() && options.scenes.empty()) return cases;
  for (const auto& one : experiment::coupling_cases())
    if (options.scenes.empty() ||
        std::find(options.scenes.begin(), options.scenes.end(), one.name) != options.scenes.end())
      cases.push_back(one);
  return cases;
}

std::vector<experiment::Scheme> schemes_of(const CouplingOptions& options,
                                           const std::vector<experiment::Scheme>& schemes) {
  std::vector<unsigned> ratios = options.ratios;
  if (ratios.empty())
    ratios = options.output.quick ? std::vector<unsigned>{2, 8, 16} : std::vector<unsigned>{1, 2, 4, 8, 16};
  const auto& borders = options.borders;
  std::vector<experiment::Scheme> chosen;
  for (experiment::Scheme scheme : schemes) {
    if (!borders.empty() && scheme.traits().border &&
        std::find(borders.begin(), borders.end(), sim::name_of(scheme.border)) == borders.end())
      continue;
    if (scheme.direct()) {
      chosen.push_back(scheme);
      continue;
    }
    for (const unsigned ratio : ratios) {
      scheme.ratio = ratio;
      chosen.push_back(scheme);
    }
  }
  return chosen;
}

// Windows for each cap on members, one after the other; the properties of a scene are those of the last.
Result<experiment::StudyReport> run_windows(const CouplingOptions& options, experiment::StudyRequest request) {
  experiment::StudyReport all;
  for (const unsigned members : options.members.empty() ? std::vector<unsigned>{0} : options.members) {
    request.members = members;
    auto report = experiment::run_coupling_study(request, experiment::terminal_progress());
    if (!report.ok()) return report;
    auto rows = std::move(all.rows);
    rows.insert(rows.end(), report.value().rows.begin(), report.value().rows.end());
    all = std::move(report).value();
    all.rows = std::move(rows);
  }
  return all;
}

Result<std::vector<experiment::WholeRunRow>> run_whole_rows(const CouplingOptions& options,
                                                            const experiment::StudyRequest& study) {
  experiment::WholeRunRequest request;
  for (const auto& one : study.cases) {
    auto scene = experiment::load_case_scene(one);
    if (!scene.ok()) return scene.status();
    request.scenes.push_back(std::move(scene).value());
    request.scenes.back().members = one.members;
  }
  for (const auto& scheme : study.schemes)
    if (!scheme.direct()) request.schemes.push_back(scheme);
  if (!options.members.empty()) request.members = options.members;
  request.seconds = options.whole_s;
  request.hand_of_direct = !options.output.quick;
  request.floor = true;
  request.order = study.order;
  return experiment::run_whole(request, experiment::terminal_progress());
}

}  // namespace

int run_coupling_experiment(const CouplingOptions& options, const std::vector<experiment::Scheme>& schemes) {
  const auto failed = [&](const Status& status) { return experiment_failed(options.name, status.message()); };
  if (options.seeds == 0 && options.whole_s <= 0)
    return failed(Status::error("--seeds 0 leaves nothing to run; give --whole SECONDS too"));
  if (options.seeds == 0 && !options.output.page.empty())
    return failed(Status::error("--page draws the windows, which --seeds 0 leaves out; accepted: --seeds 1 or more"));
  experiment::StudyRequest request;
  auto cases = cases_of(options);
  if (!cases.ok()) return failed(cases.status());
  request.cases = std::move(cases).value();
  request.schemes = schemes_of(options, schemes);
  request.seeds = options.output.quick ? std::min(2u, options.seeds) : options.seeds;
  request.order = *sim::parse_cut_order(options.order);
  request.quick = options.output.quick;
  experiment::StudyReport report;
  if (request.seeds > 0) {
    auto windows = run_windows(options, request);
    if (!windows.ok()) return failed(windows.status());
    report = std::move(windows).value();
  }
  if (options.whole_s > 0) {
    auto whole = run_whole_rows(options, request);
    if (!whole.ok()) return failed(whole.status());
    report.whole = std::move(whole).value();
  }
  const ExperimentText text{
      .name = options.name,
      .table = experiment::study_table(report),
      .json = experiment::study_json(report),
      // The windows, then the whole runs, an empty line between them.
      .csv = fmt::format("{}{}{}", request.seeds > 0 ? experiment::study_csv(report) : std::string(),
                         request.seeds > 0 && !report.whole.empty() ? "\n" : "",
                         report.whole.empty() ? std::string() : experiment::whole_csv(report.whole))};
  return draw_page(options.output, text, command_of(options, request), print_and_write(options.output, text));
}

}  // namespace tactus::tools
