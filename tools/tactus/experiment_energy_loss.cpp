// tactus experiment energy-loss: energy lost by the sub-world coupling (paper, section 3.2).
#include <CLI/CLI.hpp>

#include <memory>

#include "tools/tactus/coupling_options.h"
#include "tools/tactus/experiments.h"

namespace tactus::tools {

void add_energy_loss(CLI::App& experiment, int& exit_code) {
  auto options = std::make_shared<CouplingOptions>();
  CLI::App* command = experiment.add_subcommand(
      "energy-loss", "Measure energy and force errors of the sub-world, by border and ratio.");
  command->footer(
      "The experiment compares the sub-world, at each ratio and with each border, with direct coupling of the\n"
      "same scene and hand motion, in windows of 25 cycles (at least 200 ms) that start from the direct run's\n"
      "state. loss and gain: energy below and above the direct run's. Each is summed over the windows by itself,\n"
      "so that a gain in one window cannot hide a loss in another. Both are shares of the kinetic energy of all\n"
      "bodies (marked *, at rest: of that plus the energy in the coupling's spring; --json and --csv have both).\n" +
      std::string(kWholeRunsHelp) +
      "For windows, '1 um apart' is the deviation of two direct runs that start 1 um apart: smaller deviations cannot\n"
      "be told from chance. Virtual time: the same options give the same figures on any machine.\n\n"
      "Example:\n  tactus experiment energy-loss --quick\n"
      "  tactus experiment energy-loss --scenes pile,stack --ratios 8,16 --page energy.html\n"
      "  tactus experiment energy-loss --seeds 0 --whole 10 --scene my.toml --members 8,16 --ratios 8,16 --borders "
      "ghost");
  add_coupling_options(*command, *options);
  command->callback(
      [options, &exit_code] { exit_code = run_coupling_experiment(*options, experiment::every_border()); });
}

}  // namespace tactus::tools
