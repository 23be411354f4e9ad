// tactus control: queries a running tactus or sends it a command, over its control socket.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "tools/json_text.h"
#include "tools/service/control_server.h"
#include "tools/tactus/commands.h"
#include "tools/tactus/help_texts.h"

namespace tactus::tools {
namespace {

struct ControlOptions {
  std::string request, socket{"/run/tactus/control"};
  bool json{false};
};

std::string plain(const nlohmann::ordered_json& value) {
  if (value.is_number_float()) return fmt::format("{:.6g}", value.get<double>());
  if (value.is_array()) {
    std::string list;
    for (const auto& each : value) list += (list.empty() ? "" : ", ") + plain(each);
    return list.empty() ? "none" : list;
  }
  const std::string text = value.is_string() ? value.get<std::string>() : json_text(value);
  return text.empty() ? "none" : text;
}

void print_text(const nlohmann::ordered_json& answer) {
  if (answer.contains("said")) {
    fmt::print("{}\n", answer["said"].get<std::string>());
    return;
  }
  for (const auto& [key, value] : answer.items())
    if (key != "ok") fmt::print("{:<16} {}\n", key, plain(value));
}

int ask(const ControlOptions& options) {
  const auto answer = service::ask_control(options.socket, options.request);
  if (!answer.ok()) return complain("tactus control: " + answer.message(), kExitMachineCannot);
  const auto parsed = nlohmann::ordered_json::parse(answer.value(), nullptr, /*allow_exceptions=*/false);
  if (!parsed.is_object()) return complain("tactus control: the answer is no JSON object", kExitMachineCannot);
  const bool good = parsed.value("ok", true);
  if (options.json)
    fmt::print("{}\n", answer.value());
  else if (good)
    print_text(parsed);
  if (!good) return complain("tactus control: " + parsed.value("said", std::string("refused")), kExitVerdictBad);
  return kExitGood;
}

}  // namespace

CLI::App* add_control_command(CLI::App& program, int& exit_code) {
  auto options = std::make_shared<ControlOptions>();
  CLI::App* control =
      program.add_subcommand("control", "Send a request to a running tactus, such as state, arm, reset or stop.");
  control->footer(
      "A run has a control socket if its configuration ([control] socket) or --control names one. Whoever may write\n"
      "to the socket may send every request. Exit status: 0 done; 1 refused; 3 no run answers.\n\n"
      "Examples:\n  tactus control state --json\n  tactus control rearm --socket /run/tactus/control");
  control
      ->add_option(
          "REQUEST", options->request,
          "state, arm, rearm, disarm, reset (the scene starts again), reload, stop; in virtual time also play, pause,\n"
          "tick, cycle")
      ->required()
      ->check(CLI::IsMember(
          {"state", "arm", "rearm", "disarm", "reset", "reload", "stop", "play", "pause", "tick", "cycle"}));
  control->add_option("--socket", options->socket, help::kSocket)->capture_default_str();
  control->add_flag("--json", options->json, help::kJson);
  control->callback([options, &exit_code] { exit_code = ask(*options); });
  return control;
}

}  // namespace tactus::tools
