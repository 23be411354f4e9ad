// tactus experiment couplings: compares the coupling schemes (paper, section 3.3), and three that the paper's
// introduction cites.
#include <CLI/CLI.hpp>

#include <memory>

#include "tools/tactus/coupling_options.h"
#include "tools/tactus/experiments.h"

namespace tactus::tools {

void add_couplings(CLI::App& experiment, int& exit_code) {
  auto options = std::make_shared<CouplingOptions>();
  CLI::App* command = experiment.add_subcommand("couplings", "Compare the coupling schemes on the same hand motion.");
  command->footer(
      "direct: all bodies at the haptic rate. sub-world: the paper's method. static: the proxy moves among members\n"
      "at rest. interpolation: the device feels the proxy of the global world, interpolated over a cycle; in the\n"
      "global step a spring holds that proxy to the device. K: stiffness of that spring, marked ! where the scene's\n"
      "is not stable at this ratio and the largest stable one replaces it, in the direct run beside it too. plane,\n"
      "planes: a plane with friction for the contact that presses most, or for each contact point; new planes are\n"
      "blended in over a cycle. linearised: the force and its Jacobian.\n"
      "Errors are against direct coupling, over windows of 25 cycles (at least 200 ms) that start from its state.\n"
      "stable: a second run has the hand in the loop, with the device's encoder and delay. Its force stays below\n"
      "1.5 times the direct coupling's peak plus 1 N. While the hand holds, the force varies by at most 0.2 N more\n"
      "than with direct coupling, and its mean is at least half of the direct one's. At the end every body stands,\n"
      "and the energy never exceeds the direct run's by more than 10 % of the energy at play (both as with --whole,\n"
      "below).\n"
      "Virtual time: the same options give the same figures.\n" +
      std::string(kWholeRunsHelp) +
      "\nExamples:\n  tactus experiment couplings --quick\n  tactus experiment couplings --csv couplings.csv --page "
      "couplings.html");
  add_coupling_options(*command, *options);
  command->callback(
      [options, &exit_code] { exit_code = run_coupling_experiment(*options, experiment::every_coupling()); });
}

}  // namespace tactus::tools
