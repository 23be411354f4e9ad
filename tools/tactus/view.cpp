// tactus view: a page on a running controller.
#include <fmt/format.h>

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <nlohmann/json.hpp>

#include "tools/experiment/shared_files.h"
#include "tools/json_report.h"
#include "tools/tactus/commands.h"
#include "tools/tactus/help_texts.h"
#include "tools/tactus/in_range.h"
#include "tools/tactus/stop_signals.h"
#include "tools/view/admission.h"
#include "tools/view/live_source.h"
#include "tools/view/server.h"
#include "tools/view/tape_source.h"

namespace tactus::tools {
namespace {

struct ViewCommand {
  std::string socket{"/run/tactus/control"};
  std::string tape, beside, link;
  unsigned port{0};
  bool allow_force{false}, json{false};
};

// The run behind the socket, or the tapes.
Result<std::unique_ptr<view::ViewSource>> open_source(const ViewCommand& command,
                                                      const std::map<std::string, std::string>& files, int& exit_code) {
  if (command.tape.empty()) {
    auto live = view::LiveSource::open(command.socket);
    exit_code = kExitMachineCannot;
    if (!live.ok()) return live.status();
    live.value()->show_faults(files);
    return std::unique_ptr<view::ViewSource>(std::move(live).value());
  }
  std::vector<std::string> paths{command.tape};
  if (!command.beside.empty()) paths.push_back(command.beside);
  auto tapes = view::TapeSource::open(paths);
  exit_code = kExitBadInput;
  if (!tapes.ok()) return tapes.status();
  return std::unique_ptr<view::ViewSource>(std::move(tapes).value());
}

std::string source_name(const ViewCommand& command) {
  if (command.tape.empty()) return command.socket;
  return command.beside.empty() ? command.tape : command.tape + " beside " + command.beside;
}

// tactus view SCENE is tactus run SCENE --view: this process becomes the run.
int run_scene_with_view(const ViewCommand& command, std::vector<std::string> options) {
  std::vector<std::string> words{"tactus", "run", command.tape, "--view"};
  if (command.json) words.push_back("--json");
  words.insert(words.end(), options.begin(), options.end());
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  execv("/proc/self/exe", arguments.data());
  return complain(std::string("tactus view: the run cannot be started: ") + strerrordesc_np(errno), kExitMachineCannot);
}

int run_view(const ViewCommand& command, const std::vector<std::string>& rest) {
  if (command.tape.ends_with(".toml")) return run_scene_with_view(command, rest);
  if (!rest.empty())
    return complain("tactus view: " + rest.front() + ": no option of it; accepted: see tactus view --help",
                    kExitBadInput);
  const auto fail = [](const std::string& text, int exit_code) { return complain("tactus view: " + text, exit_code); };
  auto files = view::load_files(experiment::shared_file("view"));
  if (!files.ok()) return fail(files.message(), kExitMachineCannot);
  int exit_code = kExitGood;
  auto source = open_source(command, files.value(), exit_code);
  if (!source.ok()) return fail(source.message(), exit_code);
  view::ViewSettings settings{.port = static_cast<std::uint16_t>(command.port),
                              .allow_force = command.allow_force,
                              .files = std::move(files).value(),
                              .token = view::make_token()};
  if (settings.token.empty()) return fail("the system has no random numbers", kExitMachineCannot);
  const std::string hand = source.value()->hand();
  auto server = view::ViewServer::open(std::move(settings), std::move(source).value());
  if (!server.ok()) return fail(server.message(), kExitMachineCannot);
  stop_on_signals();
  const std::string address = server.value()->address() + (command.link.empty() ? "" : "&" + command.link);
  fmt::print(stderr, "tactus view: {}{}\n", hand.empty() ? "" : hand + ": ", address);
  const view::ViewReport report = server.value()->serve(g_stop);
  if (command.json) {
    const nlohmann::ordered_json object{{"address", address},
                                        {"source", source_name(command)},
                                        {"frames_sent", report.frames_sent},
                                        {"frames_dropped", report.frames_dropped},
                                        {"bytes", report.bytes},
                                        {"clients_most", report.clients_most},
                                        {"run_ended", report.run_ended},
                                        {"refused", report.refused}};
    fmt::print("{}\n", report_text(object, 2));
    return kExitGood;
  }
  fmt::print("tactus view: {} messages of {} bytes sent, {} frames dropped, at most {} pages{}\n", report.frames_sent,
             report.bytes, report.frames_dropped, report.clients_most, report.run_ended ? "; the run is over" : "");
  return kExitGood;
}

}  // namespace

CLI::App* add_view_command(CLI::App& program, int& exit_code) {
  auto command = std::make_shared<ViewCommand>();
  CLI::App* app = program.add_subcommand(
      "view", "Serve a browser page of a running controller, a scene or a tape: bodies, contacts, plots.");
  app->footer(
      "The program prints the address of the page; its fragment is a token that is new at every start. The server\n"
      "listens on this machine alone; from another one use ssh -L 8000:127.0.0.1:PORT. At most 4 pages. The\n"
      "viewer ends with the run; the run does not depend on the viewer. Pages may disarm and stop; requests that\n"
      "let a real device give force need --allow-force. A tape can be played and stepped at any point; bodies\n"
      "outside of the sub-world are computed from it, and where this is impossible, the page says why. Exit\n"
      "status: 0 good; 2 a run of another version, no tape; 3 no run answers, no page in this build, the port is\n"
      "in use.\n\n"
      "Examples:\n"
      "  tactus run sim/scenes/card_house.toml --control c.sock\n"
      "  tactus view --socket c.sock\n"
      "  tactus view my.tape\n"
      "  tactus view sim/scenes/card_house.toml --hand pointer\n"
      "  tactus view a.tape --beside b.tape");
  CLI::Option* tape = app->add_option("TAPE", command->tape,
                                      std::string(help::kTape) +
                                          "; or a scene, which is run as by `tactus run SCENE --view` with its\n"
                                          "options; default: a running controller");
  app->allow_extras();
  app->add_option("--beside", command->beside, "second tape, played in step with the first")->needs(tape);
  app->add_option("--socket", command->socket, help::kSocket)->capture_default_str()->excludes(tape);
  app->add_option("--link", command->link,
                  "initial state of the page: the part of its address after the token, such as at=2.5&pace=0.1");
  app->add_option("--port", command->port, "TCP port on this machine; 0: any free port")
      ->check(in_range(0u, 65535u))
      ->capture_default_str();
  app->add_flag("--allow-force", command->allow_force, "allow pages to arm, re-arm and reset a real device");
  app->add_flag("--json", command->json, help::kJson);
  app->callback([command, app, &exit_code] { exit_code = run_view(*command, app->remaining()); });
  return app;
}

}  // namespace tactus::tools
