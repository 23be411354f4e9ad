#include "tools/tactus/coupling_options.h"

#include <fmt/format.h>

#include <algorithm>

#include "sim/loader/choice_names.h"
#include "tools/experiment/page.h"
#include "tools/tactus/commands.h"
#include "tools/tactus/experiments.h"

namespace tactus::tools {
namespace {

std::vector<std::string> case_names() {
  std::vector<std::string> names;
  for (const auto& one : experiment::coupling_cases()) names.push_back(one.name);
  return names;
}

// What a person types to get the same figures.
std::string command_of(const CouplingOptions& o, const experiment::StudyRequest& request) {
  std::string text = "tactus experiment " + o.name;
  if (!o.scenes.empty()) text += fmt::format(" --scenes {}", fmt::join(o.scenes, ","));
  if (!o.borders.empty()) text += fmt::format(" --borders {}", fmt::join(o.borders, ","));
  if (!o.ratios.empty()) text += fmt::format(" --ratios {}", fmt::join(o.ratios, ","));
  text += fmt::format(" --seeds {}", request.seeds);
  if (o.members > 0) text += fmt::format(" --members {}", o.members);
  if (o.order != "best-first") text += " --order " + o.order;
  return text + (o.quick ? " --quick" : "") + " --page " + o.page;
}

}  // namespace

void add_coupling_options(CLI::App& command, CouplingOptions& options) {
  options.name = command.get_name();
  command.add_option("--scenes", options.scenes, "scenes, separated by commas; all by default")
      ->delimiter(',')
      ->check(CLI::IsMember(case_names()));
  command.add_option("--borders", options.borders, "borders, separated by commas; all that are compared by default")
      ->delimiter(',')
      ->check(CLI::IsMember({"ghost", "capped", "replay", "frozen"}));
  command.add_option("--ratios", options.ratios, "ticks per global step, separated by commas; default 1,2,4,8,16")
      ->delimiter(',')
      ->check(CLI::Range(1, 100));
  command.add_option("--seeds", options.seeds, "hands that press and slide a little differently")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command.add_option("--members", options.members, "cap of the sub-world; default: what the scene's case says")
      ->check(CLI::Range(1, 256));
  command.add_option("--order", options.order, "in which the contact graph is cut: best-first or breadth-first")
      ->check(CLI::IsMember({"best-first", "breadth-first"}))
      ->capture_default_str();
  command.add_option("--csv", options.csv, "writes the rows to this file, units in the header");
  command.add_option("--page", options.page, "draws them into this HTML file; needs python3-matplotlib");
  command.add_flag("--quick", options.quick, "about a minute: two seeds, two windows each, ratios 2, 8 and 16");
  command.add_flag("--json", options.json, "one JSON object on stdout");
}

int run_coupling_experiment(const CouplingOptions& options, const std::vector<experiment::Scheme>& schemes) {
  experiment::StudyRequest request;
  for (const auto& one : experiment::coupling_cases())
    if (options.scenes.empty() ||
        std::find(options.scenes.begin(), options.scenes.end(), one.name) != options.scenes.end())
      request.cases.push_back(one);
  std::vector<unsigned> ratios = options.ratios;
  if (ratios.empty()) ratios = options.quick ? std::vector<unsigned>{2, 8, 16} : std::vector<unsigned>{1, 2, 4, 8, 16};
  const auto asked_for = [&](const experiment::Scheme& scheme) {
    const auto& borders = options.borders;
    return borders.empty() || scheme.coupling != haptics::CouplingScheme::kSubWorld ||
           std::find(borders.begin(), borders.end(), sim::name_of(scheme.border)) != borders.end();
  };
  for (experiment::Scheme scheme : schemes) {
    if (!asked_for(scheme)) continue;
    if (scheme.coupling == haptics::CouplingScheme::kDirect) {
      scheme.ratio = 1;
      request.schemes.push_back(scheme);
      continue;
    }
    for (const unsigned ratio : ratios) {
      scheme.ratio = ratio;
      request.schemes.push_back(scheme);
    }
  }
  request.seeds = options.quick ? std::min(2u, options.seeds) : options.seeds;
  request.members = options.members;
  request.order = *sim::parse_cut_order(options.order);
  request.quick = options.quick;
  const auto report = experiment::run_coupling_study(request, experiment::terminal_progress());
  if (!report.ok())
    return complain(fmt::format("tactus experiment {}: {}", options.name, report.message()), kExitBadInput);
  const std::string json = experiment::study_json(report.value());
  fmt::print("{}\n", options.json ? json : experiment::study_table(report.value()));
  const int exit_code = write_file(options.csv, experiment::study_csv(report.value()));
  if (options.page.empty()) return exit_code;
  const Status status = experiment::write_page(options.name, json, command_of(options, request), options.page);
  return status.ok()
             ? exit_code
             : complain(fmt::format("tactus experiment {}: {}", options.name, status.message()), kExitMachineCannot);
}

}  // namespace tactus::tools
