// tactus experiment NAME: measurements on whole worlds, each with a table, JSON and files for plots.
#include <CLI/CLI.hpp>

#include "tools/tactus/commands.h"
#include "tools/tactus/experiments.h"

namespace tactus::tools {

CLI::App* add_experiment_command(CLI::App& program, int& exit_code) {
  CLI::App* experiment =
      program.add_subcommand("experiment", "Measure whole worlds: print a table or JSON, write files and plots.");
  experiment->footer("Examples:\n  tactus experiment peers --quick\n  tactus experiment scaling --quick");
  add_accuracy_cost(*experiment, exit_code);
  add_capacity(*experiment, exit_code);
  add_couplings(*experiment, exit_code);
  add_energy_loss(*experiment, exit_code);
  add_hard_cases(*experiment, exit_code);
  add_peers(*experiment, exit_code);
  add_scaling(*experiment, exit_code);
  add_stability_map(*experiment, exit_code);
  add_effects(*experiment, exit_code);
  return experiment;
}

}  // namespace tactus::tools
