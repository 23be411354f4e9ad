#include "tools/tactus/coupling_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "sim/model/choice_names.h"
#include "tools/experiment/coupling/study_fields.h"
#include "tools/tactus/commands.h"
#include "tools/tactus/coupling_parts.h"
#include "tools/tactus/experiments.h"
#include "tools/tactus/help_texts.h"
#include "tools/tactus/in_range.h"

namespace tactus::tools {
namespace {

// The arguments of `tactus` that give the same figures.
std::vector<std::string> arguments_of(const CouplingOptions& o, const experiment::StudyRequest& request) {
  std::vector<std::string> words{"experiment", o.name};
  const auto add = [&](const char* option, std::string value) {
    words.push_back(option);
    words.push_back(std::move(value));
  };
  if (!o.scenes.empty()) add("--scenes", fmt::format("{}", fmt::join(o.scenes, ",")));
  if (!o.borders.empty()) add("--borders", fmt::format("{}", fmt::join(o.borders, ",")));
  if (!o.ratios.empty()) add("--ratios", fmt::format("{}", fmt::join(o.ratios, ",")));
  add("--seeds", fmt::format("{}", request.seeds));
  for (const std::string& file : o.scene_files) add("--scene", file);
  if (o.whole_s > 0) add("--whole", fmt::format("{}", o.whole_s));
  if (!o.hands.empty()) add("--hands", fmt::format("{}", fmt::join(o.hands, ",")));
  if (!o.members.empty()) add("--members", fmt::format("{}", fmt::join(o.members, ",")));
  if (o.order != "best-first") add("--order", o.order);
  if (o.output.quick) words.push_back("--quick");
  return words;
}

}  // namespace

void add_coupling_options(CLI::App& command, CouplingOptions& options) {
  options.name = command.get_name();
  command.add_option("--scenes", options.scenes, help::kScenes)
      ->delimiter(',')
      ->check(CLI::IsMember(experiment::coupling_case_names()));
  command
      .add_option("--scene", options.scene_files, "scene file with its own hand, instead of --scenes; may be repeated")
      ->check(CLI::ExistingFile);
  command
      .add_option("--whole", options.whole_s,
                  "duration of whole runs, from rest and with the scene's own hand, that are compared too [s]")
      ->check(in_range(1.0, 600.0));
  command
      .add_option(
          "--hands", options.hands,
          "source of the device's motion in whole runs, separated by commas: closed (the simulated arm in the loop),\n"
          "direct (the motion recorded in the direct run), none (no device); default: closed,direct; with --quick: "
          "closed")
      ->delimiter(',')
      ->check(CLI::IsMember({"closed", "direct", "none"}));
  command.add_option("--borders", options.borders, help::list_of("borders of the sub-world", "all that are compared"))
      ->delimiter(',')
      ->check(CLI::IsMember(sim::border_names()));
  command.add_option("--ratios", options.ratios, help::list_of(help::kRatio, "1,2,4,8,16"))
      ->delimiter(',')
      ->check(in_range(session::kRatios));
  command.add_option("--seeds", options.seeds, help::kSeeds)->check(in_range(0, 1000))->capture_default_str();
  command.add_option("--members", options.members, help::list_of(help::kMembers, "that of the scene"))
      ->delimiter(',')
      ->check(in_range(session::kMemberCaps));
  command.add_option("--order", options.order, help::kOrder)
      ->check(CLI::IsMember({"best-first", "breadth-first"}))
      ->capture_default_str();
  options.parts.add(command);
  options.output.add_csv(command);
  options.output.add_page(command);
  options.output.add_quick(command, "two seeds, two windows each, ratios 2, 8 and 16, in about a minute");
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

}  // namespace

int run_coupling_experiment(const CouplingOptions& options, const std::vector<experiment::Scheme>& schemes) {
  const auto failed = [&](const Status& status) { return experiment_failed(options.name, status.message()); };
  if (options.seeds == 0 && options.whole_s <= 0)
    return failed(Status::error("--seeds 0 leaves nothing to run; give --whole SECONDS too"));
  if (!options.hands.empty() && options.whole_s <= 0)
    return failed(Status::error("--hands is for whole runs; give --whole SECONDS too"));
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
  if (options.parts.part >= 0)
    return print_part(options.parts, options.name, coupling_parts(options, request),
                      [&](std::size_t part) { return run_coupling_part(options, request, part); });
  CouplingOptions there = options;  // workers have files at the same path, and another working directory
  for (std::string& file : there.scene_files) file = std::filesystem::absolute(file).string();
  auto result = options.parts.elsewhere() ? run_couplings_elsewhere(options, request, arguments_of(there, request))
                                          : run_couplings_here(options, request);
  if (!result.ok()) return failed(result.status());
  const experiment::StudyReport report = std::move(result).value();
  const ExperimentText text{
      .name = options.name,
      .table = experiment::study_table(report),
      .json = experiment::study_json(report),
      // The windows, then the whole runs, an empty line between them.
      .csv = fmt::format("{}{}{}", request.seeds > 0 ? experiment::study_csv(report) : std::string(),
                         request.seeds > 0 && !report.whole.empty() ? "\n" : "",
                         report.whole.empty() ? std::string() : experiment::whole_csv(report.whole))};
  const std::string command = fmt::format("tactus {}", fmt::join(arguments_of(options, request), " "));
  return draw_page(options.output, text, command, print_and_write(options.output, text));
}

}  // namespace tactus::tools
