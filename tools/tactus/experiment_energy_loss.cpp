// tactus experiment energy-loss: energy lost by the sub-world coupling (paper, section 3.2).
#include <CLI/CLI.hpp>

#include <memory>

#include "tools/tactus/coupling_options.h"
#include "tools/tactus/experiments.h"

namespace tactus::tools {

void add_energy_loss(CLI::App& experiment, int& exit_code) {
  auto options = std::make_shared<CouplingOptions>();
  CLI::App* command =
      experiment.add_subcommand("energy-loss", "Energy and force errors of the sub-world, by border and ratio.");
  command->footer(
      "The sub-world at each ratio, with each border, beside the same scene with direct coupling: the same hand "
      "motion,\n"
      "windows that start from the direct run's state. loss and gain are of the kinetic energy of all "
      "bodies\n"
      "(*: at rest, of that and what the coupling's spring holds; --json and --csv have the two other readings); "
      "positive both, and a window that won does not hide one that "
      "lost.\n"
      "A window is 25 cycles, at least 200 ms.\n" +
      std::string(kWholeRunsHelp) +
      "For windows, '1 um apart' is how far two direct runs go apart that start so: less cannot be told from chance. "
      "Virtual time:\n"
      "the same options, the same figures, on any machine.\n\n"
      "Example:\n  tactus experiment energy-loss --quick\n"
      "  tactus experiment energy-loss --scenes pile,stack --ratios 8,16 --page energy.html\n"
      "  tactus experiment energy-loss --seeds 0 --whole 10 --scene my.toml --members 8,16 --ratios 8,16 --borders "
      "ghost");
  add_coupling_options(*command, *options);
  command->callback(
      [options, &exit_code] { exit_code = run_coupling_experiment(*options, experiment::every_border()); });
}

}  // namespace tactus::tools
