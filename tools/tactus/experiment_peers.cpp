// tactus experiment peers: time of a step compared with other engines.
#include "tools/experiment/peers.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "sim/model/choice_names.h"
#include "tools/tactus/commands.h"
#include "tools/tactus/experiment_output.h"
#include "tools/tactus/experiments.h"
#include "tools/tactus/help_texts.h"
#include "tools/tactus/in_range.h"

namespace tactus::tools {
namespace {

struct PeersOptions {
  std::vector<std::string> scenes, peers;
  std::string precision;
  unsigned sub_steps{0}, runs{3};
  OutputOptions output;
};

// Accepted words for --peers: a library, both its engines.
std::vector<std::string> peer_names() {
  std::vector<std::string> names;
  for (const auto& kind : experiment::compared_kinds()) names.emplace_back(kind.name);
  return names;
}

bool asked_for(const experiment::EngineKind& kind, const std::vector<std::string>& peers) {
  return peers.empty() || std::find(peers.begin(), peers.end(), kind.name) != peers.end();
}

// The command line that gives the same result.
std::string command_of(const PeersOptions& options) {
  std::string command = fmt::format("tactus experiment peers --runs {}", options.runs);
  if (!options.scenes.empty()) command += fmt::format(" --scenes {}", fmt::join(options.scenes, ","));
  if (!options.peers.empty()) command += fmt::format(" --peers {}", fmt::join(options.peers, ","));
  if (!options.precision.empty()) command += " --precision " + options.precision;
  if (options.sub_steps > 0) command += fmt::format(" --sub-steps {}", options.sub_steps);
  return command + (options.output.quick ? " --quick" : "");
}

int run_peers(const PeersOptions& options) {
  experiment::PeersRequest request;
  request.options.precision = sim::parse_precision(options.precision);
  request.options.sub_steps = options.sub_steps;
  request.runs = options.output.quick ? std::min(2u, options.runs) : options.runs;
  // --quick omits the large worlds unless they are named.
  std::vector<std::string> scenes = options.scenes;
  if (scenes.empty() && options.output.quick) scenes = {"pile64", "pile64-stirred", "pile1000", "pile1000-stirred"};
  for (const auto& name : experiment::scene_names())
    if (scenes.empty() || std::find(scenes.begin(), scenes.end(), name) != scenes.end())
      request.scenes.push_back(*experiment::make_scene(name, options.output.quick));
  std::vector<std::string> missing;
  for (const auto& kind : experiment::compared_kinds()) {
    if (!asked_for(kind, options.peers)) continue;
    if (kind.available)
      request.engines.push_back(kind);
    else
      missing.push_back(fmt::format("{} (Debian package {})", kind.name, kind.package));
  }
  if (!missing.empty())
    complain(
        fmt::format("tactus experiment peers: built without {}: install, then build again", fmt::join(missing, ", ")),
        request.engines.empty() ? kExitMachineCannot : kExitGood);
  if (request.engines.empty()) return kExitMachineCannot;
  const auto rows = experiment::run_peers(request, experiment::terminal_progress());
  const ExperimentText text{.name = "peers",
                            .table = experiment::peers_table(rows),
                            .json = experiment::peers_json(rows),
                            .csv = experiment::peers_csv(rows)};
  int exit_code = print_and_write(options.output, text);
  for (const auto& row : rows) {
    const auto bad = [&](const std::string& why) {
      exit_code =
          complain(fmt::format("tactus experiment peers: {}, {}: {}", row.scene, row.engine, why), kExitVerdictBad);
    };
    if (!row.failure.empty()) bad(row.failure);
    if (!row.missed_gate.empty() && row.engine == "tactus") bad(row.missed_gate);
  }
  return draw_page(options.output, text, command_of(options), exit_code);
}

}  // namespace

void add_peers(CLI::App& experiment, int& exit_code) {
  auto options = std::make_shared<PeersOptions>();
  CLI::App* peers =
      experiment.add_subcommand("peers", "Compare the cost of a step with that of other engines, on identical scenes.");
  peers->footer(
      "One core, CPU time; the engines take turns in blocks of steps. The peers run at their defaults and tuned,\n"
      "with fewer and with more iterations too. They are Debian packages found when tactus was built:\n"
      "libbullet-dev, libode-dev, and libmujoco-dev, for up to 100 bodies and no terrain. Stirred scenes have the\n"
      "same kinematic rods in every engine. Overlaps, travel and bodies that left the box are computed from the\n"
      "poses, alike for all engines; the time of a row that misses a gate is not compared. Exit status 1: a\n"
      "capacity cut the work of a row, which then does not count, or tactus misses a gate.\n\n"
      "Examples:\n"
      "  tactus experiment peers --quick\n"
      "  tactus experiment peers --scenes pile1000 --peers tactus,bullet");
  const auto& names = experiment::scene_names();
  peers->add_option("--scenes", options->scenes, help::kScenes)
      ->delimiter(',')
      ->check(CLI::IsMember(std::vector<std::string>(names.begin(), names.end())));
  peers->add_option("--peers", options->peers, "engines, separated by commas; default: all")
      ->delimiter(',')
      ->check(CLI::IsMember(peer_names()));
  peers->add_option("--precision", options->precision, std::string("precision of tactus: ") + help::kPrecision)
      ->check(CLI::IsMember({"double", "mixed"}));
  peers
      ->add_option("--sub-steps", options->sub_steps,
                   "sub-steps of tactus per step; contact frequency: 0.2 / sub-step, 250 Hz at most; default: 4 in 1 "
                   "ms, 10 in 10 ms")
      ->check(in_range(1, 100));
  peers->add_option("--runs", options->runs, "number of identical runs of each scene")
      ->check(in_range(1, 9))
      ->capture_default_str();
  options->output.add_quick(*peers, "1 s to settle, a fifth of the steps, two runs, no large worlds");
  options->output.add_csv(*peers);
  options->output.add_page(*peers);
  options->output.add_json(*peers);
  peers->callback([options, &exit_code] { exit_code = run_peers(*options); });
}

}  // namespace tactus::tools
