#include "tools/tactus/experiment_output.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <filesystem>

#include "tools/experiment/page.h"
#include "tools/tactus/commands.h"

namespace tactus::tools {

void OutputOptions::add_csv(CLI::App& command, const char* help) { command.add_option("--csv", csv, help); }
void OutputOptions::add_svg(CLI::App& command, const char* help) { command.add_option("--svg", svg, help); }
void OutputOptions::add_page(CLI::App& command, const char* what) {
  command.add_option("--page", page, fmt::format("draws {} into this HTML file; needs python3-matplotlib", what));
}
void OutputOptions::add_quick(CLI::App& command, const char* help) { command.add_flag("--quick", quick, help); }
void OutputOptions::add_json(CLI::App& command) { command.add_flag("--json", json, "one JSON object on stdout"); }

int print_and_write(const OutputOptions& options, const ExperimentText& text) {
  fmt::print("{}\n", options.json ? text.json : text.table);
  const int csv = write_file(options.csv, text.csv);
  return std::max(csv, write_file(options.svg, text.svg));
}

int draw_page(const OutputOptions& options, const ExperimentText& text, const std::string& command, int exit_code) {
  if (options.page.empty()) return exit_code;
  const Status status = experiment::write_page(text.page, text.json, command + " --page " + options.page, options.page);
  return status.ok()
             ? exit_code
             : complain_after(fmt::format("tactus experiment {}: {}", text.name, status.message()), kExitMachineCannot);
}

int experiment_failed(const std::string& name, const std::string& why) {
  return complain(fmt::format("tactus experiment {}: {}", name, why), kExitBadInput);
}

std::string own_program() {
  std::error_code ignored;
  return std::filesystem::read_symlink("/proc/self/exe", ignored).string();
}

}  // namespace tactus::tools
