// tactus view: a page on a running controller.
#include <fmt/format.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "tools/experiment/shared_files.h"
#include "tools/json_report.h"
#include "tools/service/control_server.h"
#include "tools/tactus/commands.h"
#include "tools/view/admission.h"
#include "tools/view/server.h"

namespace tactus::tools {
namespace {

std::atomic<bool> g_stop_view{false};  // set by SIGINT and SIGTERM
void ask_to_stop(int) { g_stop_view.store(true); }

struct ViewCommand {
  std::string socket{"/run/tactus/control"};
  unsigned port{0};
  bool allow_force{false}, json{false};
};

int run_view(const ViewCommand& command) {
  const auto fail = [](const std::string& text, int exit_code) { return complain("tactus view: " + text, exit_code); };
  auto files = view::load_files(experiment::shared_file("view"));
  if (!files.ok()) return fail(files.message(), kExitMachineCannot);
  const auto run = service::watch_control(command.socket);
  if (!run.ok()) return fail(run.message(), kExitMachineCannot);
  auto watcher = publication::Watcher::open(run.value().memory);
  if (!watcher.ok()) return fail(watcher.message(), kExitBadInput);
  view::ViewSettings settings{static_cast<std::uint16_t>(command.port),
                              command.allow_force,
                              run.value().connection,
                              command.socket,
                              std::move(files).value(),
                              view::make_token()};
  if (settings.token.empty()) return fail("the system has no random numbers", kExitMachineCannot);
  auto server = view::ViewServer::open(std::move(settings), std::move(watcher).value());
  if (!server.ok()) return fail(server.message(), kExitMachineCannot);
  std::signal(SIGINT, ask_to_stop);
  std::signal(SIGTERM, ask_to_stop);
  const std::string address = server.value()->address();
  fmt::print(stderr, "tactus view: {}\n", address);
  const view::ViewReport report = server.value()->serve(g_stop_view);
  close(run.value().connection);  // the run is watched until here
  if (command.json) {
    const nlohmann::ordered_json object{{"address", address},
                                        {"source", command.socket},
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
  CLI::App* app = program.add_subcommand("view", "A page on a running controller: bodies, contacts, plots.");
  app->footer(
      "Prints the page's address, whose fragment is a token of this start; it listens on this machine alone. From\n"
      "another one: ssh -L 8000:127.0.0.1:PORT. At most 4 pages. The run goes on whatever happens to the viewer; it "
      "ends\n"
      "with the run. Pages may disarm and stop; what gives force to a real device needs --allow-force.\n"
      "Exit status: 0 good; 2 a run of another version; 3 no run answers, no page in this build, the port is in "
      "use.\n\n"
      "Example:\n  tactus run sim/scenes/card_house.toml --control c.sock\n  tactus view --socket c.sock");
  app->add_option("--socket", command->socket, "control socket of the run")->capture_default_str();
  app->add_option("--port", command->port, "on this machine; 0: any that is free")
      ->check(CLI::Range(0u, 65535u))
      ->capture_default_str();
  app->add_flag("--allow-force", command->allow_force, "pages may arm, re-arm and reset a real device");
  app->add_flag("--json", command->json, "one JSON object on stdout, at the end");
  app->callback([command, &exit_code] { exit_code = run_view(*command); });
  return app;
}

}  // namespace tactus::tools
