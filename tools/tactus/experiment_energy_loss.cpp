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
      "state. Virtual time: the same options give the same figures on any machine. Of windows:\n"
      "  loss, gain    energy below and above the direct run's, as shares of the kinetic energy of all bodies. Each\n"
      "                is summed over the windows by itself: a gain in one window cannot hide a loss in another\n"
      "  *             bodies at rest: shares of that energy plus the energy in the coupling's spring; --json and\n"
      "                --csv have both\n"
      "  1 um apart    deviation of two direct runs that start 1 um apart: smaller deviations are chance\n" +
      std::string(kWholeRunsHelp) +
      "\nExamples:\n  tactus experiment energy-loss --quick\n"
      "  tactus experiment energy-loss --scenes pile,stack --ratios 8,16 --page energy.html\n"
      "  tactus experiment energy-loss --seeds 0 --whole 10 --scene my.toml --members 8,16 --ratios 8,16 --borders "
      "ghost");
  add_coupling_options(*command, *options);
  command->callback(
      [options, &exit_code] { exit_code = run_coupling_experiment(*options, experiment::every_border()); });
}

}  // namespace tactus::tools
