// The tactus program: selects the subcommand, and reports in one line what is wrong with a command line.
#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <exception>
#include <fstream>
#include <memory>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "rt/text/nearest_word.h"
#include "rt/text/without_control.h"
#include "tools/json_report.h"
#include "tools/tactus/commands.h"
#include "tools/version/version.h"

namespace tactus::tools {
namespace {

bool g_json{false};  // --json is on the command line, even if other options are invalid

void print_error_object(const std::string& text, int exit_code) {
  if (!g_json || (exit_code != kExitBadInput && exit_code != kExitMachineCannot)) return;
  fmt::print("{}\n", report_text(nlohmann::ordered_json{{"error", text}, {"exit_code", exit_code}}, 2));
}

// The innermost subcommand given; the program itself if none was.
const CLI::App& innermost(const CLI::App& program) {
  const CLI::App* app = &program;
  while (!app->get_subcommands().empty()) app = app->get_subcommands().front();
  return *app;
}

std::string path_of(const CLI::App& app) {
  return app.get_parent() == nullptr ? app.get_name() : path_of(*app.get_parent()) + " " + app.get_name();
}

std::vector<std::string> subcommands_of(const CLI::App& app) {
  std::vector<std::string> names;
  for (const auto* sub : app.get_subcommands([](const CLI::App*) { return true; })) names.push_back(sub->get_name());
  return names;
}

std::string joined(const std::vector<std::string>& words) { return fmt::format("{}", fmt::join(words, ", ")); }

// Explains an unused word: an unknown option, an unknown subcommand, or one argument too many.
std::string explain_extra(const CLI::App& app, const std::string& extra) {
  std::vector<std::string> known = subcommands_of(app);
  const bool is_option = extra.starts_with("-");
  if (is_option) {
    known.clear();
    for (const auto* option : app.get_options())
      for (const auto& name : option->get_lnames()) known.push_back("--" + name);
  }
  const std::string word = extra.substr(0, extra.find('='));
  const std::vector<std::string_view> views(known.begin(), known.end());
  const auto nearest = text::nearest_word(word, views);
  const char* what = is_option ? "no such option" : known.empty() ? "one argument too many" : "no such command";
  return fmt::format("{}: {}: {}{}; accepted: {}", path_of(app), word, what,
                     nearest.empty() ? "" : fmt::format(", did you mean {}?", nearest),
                     known.empty() ? fmt::format("see {} --help", path_of(app)) : joined(known));
}

std::string explain_other(const CLI::App& app, const std::string& said) {
  if (said.find("; accepted: ") != std::string::npos) return fmt::format("{}: {}", path_of(app), said);
  return fmt::format("{}: {}; accepted: see {} --help", path_of(app), said, path_of(app));
}

// Explains a value that is of another type than the option's: CLI11 says "Could not convert: --ratio = 10.0".
std::string explain_value(const CLI::App& app, const std::string& said) {
  const std::string unexplained = explain_other(app, said);
  const std::size_t name = said.find("--"), equals = said.find(" = ");
  if (name == std::string::npos || equals == std::string::npos || equals < name) return unexplained;
  const CLI::Option* option = app.get_option_no_throw(said.substr(name, equals - name));
  if (option == nullptr) return unexplained;
  const std::string type = option->get_type_name();
  const char* accepted = type.starts_with("UINT")    ? "a whole number, 0 or more"
                         : type.starts_with("INT")   ? "a whole number"
                         : type.starts_with("FLOAT") ? "a number, such as 0.5"
                                                     : nullptr;
  if (accepted == nullptr) return unexplained;
  return fmt::format("{}: {}: '{}' is none; accepted: {}: {}", path_of(app), option->get_name(),
                     said.substr(equals + 3), accepted, option->get_description());
}

int parse_and_run(CLI::App& program, int argc, char** argv, const int& exit_code) {
  try {
    program.parse(argc, argv);
  } catch (const CLI::Success& help) {
    return program.exit(help);  // --help: the text on stdout
  } catch (const CLI::ExtrasError&) {
    const auto extras = program.remaining(true);
    return complain(explain_extra(innermost(program), extras.empty() ? "" : extras.front()), kExitBadInput);
  } catch (const CLI::ConversionError& error) {
    return complain(explain_value(innermost(program), error.what()), kExitBadInput);
  } catch (const CLI::ParseError& error) {
    const int status = error.get_exit_code() == kExitMachineCannot ? kExitMachineCannot : kExitBadInput;
    return complain(explain_other(innermost(program), error.what()), status);
  }
  const CLI::App& named = innermost(program);
  const auto subcommands = subcommands_of(named);
  if (!subcommands.empty())
    return complain(
        fmt::format("{}: no command; accepted: {}; see {} --help", path_of(named), joined(subcommands), path_of(named)),
        kExitBadInput);
  return exit_code;
}

// CLI11's help text, with one blank line between the options and the text below. CLI11 prints two if a command has
// hidden options.
class HelpFormatter : public CLI::Formatter {
 public:
  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override {
    std::string text = CLI::Formatter::make_help(app, std::move(name), mode);
    if (const std::size_t at = text.find("\n\n\n"); at != std::string::npos) text.erase(at, 1);
    return text;
  }
};

int run_program(int argc, char** argv) {
  g_json = std::find(argv, argv + argc, std::string("--json")) != argv + argc;
  CLI::App program{"tactus: feel a large world of rigid bodies through a force-feedback device, at 1 kHz."};
  program.name("tactus");
  program.formatter(std::make_shared<HelpFormatter>());
  program.footer(
      "Examples:\n  tactus run sim/scenes/card_house.toml --duration 20\n"
      "  tactus scene check sim/scenes/card_house.toml\n\n"
      "Every command has --help with an example. Exit status: 0 good; 1 it ran and the verdict is bad;\n"
      "2 bad usage or input; 3 the machine cannot do it.");
  program.set_version_flag("--version", version_text, "print version, commit, build target and kernel, and exit");
  int exit_code = kExitGood;
  add_run_command(program, exit_code);
  add_hil_command(program, exit_code);
  add_device_command(program, exit_code);
  add_replay_command(program, exit_code);
  add_export_command(program, exit_code);
  add_import_command(program, exit_code);
  add_view_command(program, exit_code);
  add_scene_command(program, exit_code);
  add_doctor_command(program, exit_code);
  add_timing_command(program, exit_code);
  add_tune_command(program, exit_code);
  add_config_command(program, exit_code);
  add_control_command(program, exit_code);
  add_experiment_command(program, exit_code);
  add_sweep_command(program, exit_code);
  return parse_and_run(program, argc, argv, exit_code);
}

int after_output(int exit_code) {
  const bool lost = std::fflush(stdout) != 0 || std::ferror(stdout) != 0;
  if (!lost || exit_code != kExitGood) return exit_code;
  return complain_after("standard output cannot be written; accepted: a file or a pipe that takes it",
                        kExitMachineCannot);
}

}  // namespace

int complain(const std::string& text, int exit_code) {
  print_error_object(text, exit_code);
  return complain_after(text, exit_code);
}

int complain_of_each(const std::string& lines, int exit_code) {
  print_error_object(lines, exit_code);
  fmt::print(stderr, "tactus: {}\n", text::without_control(lines, '\n'));
  return exit_code;
}

int complain_after(const std::string& text, int exit_code) {
  std::string line = text::without_control(text, '\n');
  std::replace(line.begin(), line.end(), '\n', ' ');
  // A text that begins with a command's path begins with the program's name already.
  fmt::print(stderr, "{}{}\n", line.starts_with("tactus") ? "" : "tactus: ", line);
  return exit_code;
}

int write_file(const std::string& path, const std::string& text) {
  if (path.empty()) return kExitGood;
  std::ofstream file(path);
  file << text;
  file.close();
  return file.good() ? kExitGood : complain_after(fmt::format("{}: cannot be written", path), kExitBadInput);
}

}  // namespace tactus::tools

int main(int argc, char** argv) {
  // A write beyond the file size limit is then an error of that file and does not end the run.
  std::signal(SIGXFSZ, SIG_IGN);
  try {
    return tactus::tools::after_output(tactus::tools::run_program(argc, argv));
  } catch (const std::bad_alloc&) {
    return tactus::tools::complain("out of memory", tactus::tools::kExitMachineCannot);
  } catch (const std::exception& error) {
    return tactus::tools::complain(error.what(), tactus::tools::kExitMachineCannot);
  }
}
