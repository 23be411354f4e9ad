// Options that the experiments share (--csv, --svg, --page, --quick, --json), and the end of an experiment, which
// prints a table or JSON, writes the files and draws the page. Thread: [setup].
#pragma once

#include <string>

namespace CLI {
class App;
}

namespace tactus::tools {

struct OutputOptions {
  std::string csv, svg, page;  // paths; empty: not wanted
  bool quick{false}, json{false};

  // Each adds its option, with the same help text in every experiment.
  void add_csv(CLI::App& command);
  void add_svg(CLI::App& command, const char* what);  // "plot {what} in this SVG file"
  void add_page(CLI::App& command);
  void add_quick(CLI::App& command, const char* how);  // "measure less: {how}"
  void add_json(CLI::App& command);
};

// A finished run, as text.
struct ExperimentText {
  std::string name;  // of the experiment
  std::string table{}, json{}, csv{}, svg{};
  std::string page{name};  // how tools/experiment_page calls it
};

// Prints the table, or with --json the JSON, and writes the files. Returns the exit status; reports a file that cannot
// be written.
int print_and_write(const OutputOptions& options, const ExperimentText& text);
// Draws the page, if one is wanted. `command`: the command line that gives the same figures, without --page. Returns
// `exit_code`, or what a page that could not be drawn ends with.
int draw_page(const OutputOptions& options, const ExperimentText& text, const std::string& command, int exit_code);

// Reports on standard error that the experiment failed, and returns the exit status of bad input.
int experiment_failed(const std::string& name, const std::string& why);

// The path of this program, which an experiment runs again to count instructions.
std::string own_program();

}  // namespace tactus::tools
