// tactus replay TAPE: run a tape again and compare every output, bit by bit.
#include "tools/session/replay.h"
#include "tools/json_report.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "tools/tactus/commands.h"
#include "tools/tactus/help_texts.h"

namespace tactus::tools {
namespace {

struct ReplayOptions {
  std::string tape;
  bool json{false};
};

int run_replay(const ReplayOptions& options) {
  const bool terminal = !options.json && isatty(STDERR_FILENO) != 0;
  const auto result = session::replay(options.tape, [&](double share) {
    if (terminal) fmt::print(stderr, "\rreplaying {:3.0f} % ", 100 * share);
  });
  if (terminal) fmt::print(stderr, "\r\033[K");
  if (!result.ok()) return complain(result.message(), kExitBadInput);
  const session::ReplayReport& r = result.value();
  if (options.json) {
    const nlohmann::ordered_json object{{"tape", options.tape},
                                        {"made_by", r.made_by},
                                        {"scene", r.scene_name},
                                        {"scene_file", r.scene_file},
                                        {"scene_hash", r.scene_hash},
                                        {"good", r.good()},
                                        {"same_bits", r.same_bits()},
                                        {"ticks", r.ticks},
                                        {"compared_ticks", r.compared},
                                        {"different_ticks", r.different},
                                        {"first_different_tick", r.first_different_tick},
                                        {"first_difference", r.first_difference},
                                        {"keyframes", r.keyframes},
                                        {"different_keyframes", r.keyframes_different},
                                        {"snapshots", r.snapshots},
                                        {"gaps", r.gaps},
                                        {"unreplayable_ticks", r.unreplayable},
                                        {"damages", r.damages},
                                        {"lost_ticks", r.lost_ticks},
                                        {"lost_bytes", r.lost_bytes},
                                        {"damage", r.damage},
                                        {"warning", r.warning},
                                        {"state_hash", fmt::format("{:016x}", r.state_hash)}};
    fmt::print("{}\n", report_text(object, 2));
    return r.good() ? kExitGood : kExitVerdictBad;
  }
  if (!r.warning.empty()) fmt::print(stderr, "tactus: warning: {}\n", r.warning);
  const char* verdict = !r.same_bits()   ? r.compared == 0 ? "NOTHING TO COMPARE" : "DIFFERENT"
                        : r.damages != 0 ? "DAMAGED; the same bits in what can be read"
                                         : "the same bits";
  fmt::print("tactus replay: {} ({})\n", options.tape, verdict);
  fmt::print("  made by              {}\n", r.made_by.empty() ? "a program that did not say" : r.made_by);
  fmt::print("  of the scene         {}, {}, text {}\n", r.scene_name, r.scene_file, r.scene_hash);
  fmt::print("  replayed by          tactus {}\n", version());
  fmt::print("  ticks                {} on the tape, {} compared, {} different\n", r.ticks, r.compared, r.different);
  fmt::print("  keyframes            {}, {} different; {} snapshots\n", r.keyframes, r.keyframes_different,
             r.snapshots);
  fmt::print("  gaps                 {}; {} ticks before a keyframe could not be replayed\n", r.gaps, r.unreplayable);
  if (r.damages > 0)
    fmt::print("  damage               {} places, {} ticks and {} bytes lost there; the first: {}\n", r.damages,
               r.lost_ticks, r.lost_bytes, r.damage);
  if (r.different > 0) fmt::print("  first difference     tick {}: {}\n", r.first_different_tick, r.first_difference);
  fmt::print("  state hash           {:016x}\n", r.state_hash);
  return r.good() ? kExitGood : kExitVerdictBad;
}

}  // namespace

CLI::App* add_replay_command(CLI::App& program, int& exit_code) {
  auto options = std::make_shared<ReplayOptions>();
  CLI::App* command = program.add_subcommand("replay", "Run a tape again and compare every output, bit by bit.");
  command->footer(
      "The tape holds the samples of the device, the snapshots of the global world and the choices of the governor.\n"
      "The replay computes every tick again, and prints the version and the scene that made the tape. Where a\n"
      "record is damaged, it prints what is lost and continues at the next keyframe.\n"
      "Exit status: 0 the same bits; 1 different, or a part of the tape is lost; 2 no such tape.\n\n"
      "Examples:\n"
      "  tactus run sim/scenes/card_house.toml --duration 5 --record my.tape\n"
      "  tactus replay my.tape");
  command->add_option("TAPE", options->tape, help::kTape)->required();
  command->add_flag("--json", options->json, help::kJson);
  command->callback([options, &exit_code] { exit_code = run_replay(*options); });
  return command;
}

}  // namespace tactus::tools
