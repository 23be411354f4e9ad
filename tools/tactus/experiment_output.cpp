#include "tools/tactus/experiment_output.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <filesystem>

#include "tools/experiment/page.h"
#include "tools/tactus/commands.h"
#include "tools/tactus/help_texts.h"
#include "tools/tactus/output_option.h"
#include "tools/version/provenance.h"

namespace tactus::tools {

void OutputOptions::add_csv(CLI::App& command) {
  add_output(command, "--csv", csv, exporting::OutputKind::kCsv,
             "write all measured rows to this CSV file, with units in the header");
}
void OutputOptions::add_svg(CLI::App& command, const char* what) {
  add_output(command, "--svg", svg, exporting::OutputKind::kSvg, fmt::format("plot {} in this SVG file", what));
}
void OutputOptions::add_page(CLI::App& command) {
  add_output(command, "--page", page, exporting::OutputKind::kPage,
             "write a page with plots to this HTML file; needs python3-matplotlib")
      ->check([](const std::string&) {
        const Status status = experiment::check_page_writer();
        if (!status.ok()) throw CLI::RuntimeError(status.message(), kExitMachineCannot);
        return std::string();
      });
}
void OutputOptions::add_quick(CLI::App& command, const char* how) {
  command.add_flag("--quick", quick, fmt::format("measure less: {}", how));
}
void OutputOptions::add_json(CLI::App& command) { command.add_flag("--json", json, help::kJson); }

int print_and_write(const OutputOptions& options, const ExperimentText& text) {
  fmt::print("{}\n", options.json ? text.json : text.table);
  const int csv = write_file(options.csv, text.csv);
  return std::max(csv, write_file(options.svg, text.svg));
}

int draw_page(const OutputOptions& options, const ExperimentText& text, const std::string& command, int exit_code) {
  if (options.page.empty()) return exit_code;
  const Status status =
      experiment::write_page(text.page, text.json, command + " --page " + shell_word(options.page), options.page);
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
