// tactus experiment hard-cases: small worlds with known answers, scored.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/json_report.h"
#include "tools/tactus/commands.h"
#include "tools/tactus/experiment_output.h"
#include "tools/tactus/experiment_parts.h"
#include "tools/tactus/experiments.h"
#include "tools/tactus/help_texts.h"
#include "tools/validation/random_world.h"
#include "tools/validation/report.h"
#include "tools/validation/trial_report.h"

namespace tactus::tools {
namespace {

struct HardCasesOptions {
  std::vector<int> cases;
  std::vector<std::string> accuracies;
  std::vector<double> steps_ms{1, 10};
  std::uint64_t random{0}, first{0};
  bool sub_world{false}, no_peers{false};
  PartOptions parts;
  OutputOptions output;
};

// A part is the random worlds of so many seeds: seconds of work.
constexpr std::uint64_t kSeedsInPart = 10;
std::size_t parts_in(const HardCasesOptions& options) { return (options.random + kSeedsInPart - 1) / kSeedsInPart; }

std::vector<std::string> arguments_of(const HardCasesOptions& options) {
  std::vector<std::string> words{"experiment", "hard-cases",
                                 "--random",   fmt::format("{}", options.random),
                                 "--first",    fmt::format("{}", options.first)};
  if (options.sub_world) words.push_back("--sub-world");
  return words;
}

// Calls take(result) with each result of compute(first seed, number of seeds), in the order of the seeds; the results
// are computed in this process or by the workers.
template <class Compute, class Take>
Status for_each_part(const HardCasesOptions& options, Compute&& compute, Take&& take) {
  using Part = decltype(compute(options.first, options.random));
  if (options.parts.elsewhere()) {
    auto parts =
        parts_of<Part>(options.parts, {.arguments = arguments_of(options), .count = parts_in(options), .scenes = {}});
    if (!parts.ok()) return parts.status();
    for (Part& part : parts.value()) take(std::move(part));
    return Status::good();
  }
  for (std::uint64_t seed = options.first; seed < options.first + options.random; ++seed) take(compute(seed, 1));
  return Status::good();
}

template <class Compute>
int print_seeds(const HardCasesOptions& options, Compute&& compute) {
  return print_part(options.parts, "hard-cases", parts_in(options), [&](std::size_t part) {
    const std::uint64_t before = part * kSeedsInPart;
    return Result(compute(options.first + before, std::min(kSeedsInPart, options.random - before)));
  });
}

// A world that fails a gate is written as a scene file. Worlds whose bodies rotate faster than the integrator is
// designed for are listed separately.
int run_random_worlds(const HardCasesOptions& options) {
  if (options.parts.part >= 0) return print_seeds(options, hard_cases::broken_worlds);
  const experiment::Progress progress = experiment::terminal_progress();
  const experiment::WorkProgress pace(progress, static_cast<double>(options.random));
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  int exit_code = kExitGood;
  double done = 0;
  const auto take = [&](const std::vector<hard_cases::BrokenWorld>& broken) {
    if (std::fmod(done, 100) == 0) pace.say(fmt::format("{} worlds, {} broke a gate", done, rows.size()), done);
    done += 1;
    for (const auto& world : broken) {
      const std::string path = fmt::format("random-world-{}.toml", world.seed);
      if (write_file(path, world.scene) != kExitGood) exit_code = kExitBadInput;
      rows.push_back({{"seed", world.seed}, {"gate", world.gate}, {"file", path}});
      if (!options.output.json) fmt::print("seed {}: gate broken: {}; {}\n", world.seed, world.gate, path);
    }
  };
  if (const Status status = for_each_part(options, hard_cases::broken_worlds, take); !status.ok())
    return experiment_failed("hard-cases", status.message());
  const std::size_t broken = rows.size();
  if (options.output.json)
    fmt::print("{}\n",
               report_text(nlohmann::ordered_json{{"worlds", options.random}, {"broken", broken}, {"rows", rows}}, 2));
  else
    fmt::print("{} of {} random worlds from seed {} broke a gate\n", broken, options.random, options.first);
  return exit_code != kExitGood ? exit_code : broken == 0 ? kExitGood : kExitVerdictBad;
}

// Writes the worst worlds as scene files.
int run_random_trials(const HardCasesOptions& options) {
  if (options.parts.part >= 0) return print_seeds(options, hard_cases::try_seeds);
  hard_cases::TrialReport report;
  report.first = options.first;
  report.worlds = options.random;
  const experiment::Progress progress = experiment::terminal_progress();
  const experiment::WorkProgress pace(progress, static_cast<double>(options.random));
  const auto take = [&](hard_cases::Trials trials) {
    report.add(std::move(trials));
    const std::size_t done = report.rows.size() + report.left_out.size();
    pace.say(fmt::format("{} worlds, {} collapsed", done, report.collapsed()), static_cast<double>(done));
  };
  if (const Status status = for_each_part(options, hard_cases::try_seeds, take); !status.ok())
    return experiment_failed("hard-cases", status.message());
  const ExperimentText text{.name = "hard-cases",
                            .table = hard_cases::trial_text(report),
                            .json = hard_cases::trial_json(report),
                            .csv = experiment::whole_csv(report.rows),
                            .page = "random-worlds"};
  int written = print_and_write(options.output, text);
  for (const auto& trial : report.worst)
    written = std::max(written, write_file(fmt::format("random-world-{}.toml", trial.seed), trial.scene));
  const std::string command = fmt::format("tactus {}", fmt::join(arguments_of(options), " "));
  return draw_page(options.output, text, command, report.collapsed() == 0 ? written : kExitVerdictBad);
}

int run_hard_cases(const HardCasesOptions& options) {
  if ((options.sub_world || !options.output.page.empty()) && !(options.sub_world && options.random > 0))
    return complain(
        "tactus experiment hard-cases: --sub-world and --page are of random worlds; accepted: --random N --sub-world",
        kExitBadInput);
  if ((options.parts.elsewhere() || options.parts.part >= 0) && options.random == 0)
    return complain(
        "tactus experiment hard-cases: --workers and --scheduler are of random worlds; accepted: --random N",
        kExitBadInput);
  if (options.sub_world) return run_random_trials(options);
  if (options.random > 0) return run_random_worlds(options);
  const auto asked = [](const auto& list, const auto& one) {
    return list.empty() || std::find(list.begin(), list.end(), one) != list.end();
  };
  hard_cases::Request request;
  for (const auto& one : hard_cases::hard_cases())
    if (asked(options.cases, one.number)) request.cases.push_back(&one);
  if (request.cases.empty()) return experiment_failed("hard-cases", "--cases: no such case");
  for (const auto accuracy : hard_cases::kAccuracies)
    if (asked(options.accuracies, std::string(hard_cases::name_of(accuracy)))) request.accuracies.push_back(accuracy);
  for (const double step_ms : options.steps_ms) request.steps_s.push_back(1e-3 * step_ms);
  if (!options.no_peers && options.cases.empty())
    for (const auto& kind : experiment::engine_kinds())
      if (kind.available && kind.name != "tactus") request.peers.push_back(kind);
  const auto report = hard_cases::run(request, experiment::terminal_progress());
  const int written = print_and_write(options.output, {.name = "hard-cases",
                                                       .table = hard_cases::report_table(report),
                                                       .json = hard_cases::report_json(report),
                                                       .csv = hard_cases::report_csv(report),
                                                       .svg = hard_cases::report_svg(report)});
  if (!options.output.json) fmt::print("{}", hard_cases::failures_text(report));
  if (!report.all_pass_at(hard_cases::Accuracy::kBalanced)) return kExitVerdictBad;
  return written;
}

}  // namespace

void add_hard_cases(CLI::App& experiment, int& exit_code) {
  auto options = std::make_shared<HardCasesOptions>();
  CLI::App* command = experiment.add_subcommand(
      "hard-cases", "Run small worlds with known answers and score them at three accuracies.");
  command->footer(
      "Steps of 1 ms and 10 ms. Sub-steps by accuracy: fast 2 and 10, balanced 4 and 40, accurate 16 and 160 with\n"
      "two relax sweeps; contacts are as stiff as the case asks for and the sub-step resolves. Without --cases,\n"
      "stacks are also run by the other engines that were found when tactus was built. Exit status 1: a case fails\n"
      "at the balanced accuracy.\n\n"
      "--random N --sub-world: a world collapses if a body falls that stands in three direct runs: the same run,\n"
      "one in which every body starts up to 1 um aside in each coordinate, and one with twice the sub-steps; or if\n"
      "the force is not finite or exceeds 10 kN. When a body falls: see `stands` in tactus experiment energy-loss\n"
      "--help. A body that also falls in one of the last two direct runs falls by chance. Counted apart are worlds\n"
      "that start with bodies overlapping by more than half of the thinner one, since no run of them is good, and\n"
      "bodies that stood still from the start. --page shows the ten worst worlds; --workers and --scheduler divide\n"
      "the random worlds. Exit status 1: a world collapses.\n\n"
      "Examples:\n  tactus experiment hard-cases --svg scores.svg\n  tactus experiment hard-cases --cases 2,102\n"
      "  tactus experiment hard-cases --random 100 --sub-world --page worst.html");
  command->add_option("--cases", options->cases, "numbers of the cases, separated by commas; default: all")
      ->delimiter(',');
  command->add_option("--accuracies", options->accuracies, "accuracies, separated by commas; default: all")
      ->delimiter(',')
      ->check(CLI::IsMember({"fast", "balanced", "accurate"}));
  command->add_option("--steps-ms", options->steps_ms, "lengths of the step [ms], separated by commas; default: both")
      ->delimiter(',')
      ->check(CLI::IsMember({1.0, 10.0}));
  options->output.add_csv(*command);
  options->output.add_svg(*command, "the scores");
  command->add_option("--random", options->random, "number of random worlds, which are run instead of the cases");
  command->add_option("--first", options->first, "seed of the first random world")->capture_default_str();
  command->add_flag(
      "--sub-world", options->sub_world,
      "run each random world with a hand for 5 s, by the sub-world (ghosts, ratio 8) and by direct coupling;\n"
      "write the ten worst as scene files");
  options->parts.add(*command);
  options->output.add_page(*command);
  command->add_flag("--no-peers", options->no_peers, "leave the other engines out");
  options->output.add_json(*command);
  command->callback([options, &exit_code] { exit_code = run_hard_cases(*options); });
}

}  // namespace tactus::tools
