// tactus experiment couplings: compares the coupling schemes (paper, section 3.3), and three that the paper's
// introduction cites.
#include <CLI/CLI.hpp>

#include <memory>

#include "tools/tactus/coupling_options.h"
#include "tools/tactus/experiments.h"

namespace tactus::tools {

void add_couplings(CLI::App& experiment, int& exit_code) {
  auto options = std::make_shared<CouplingOptions>();
  CLI::App* command = experiment.add_subcommand("couplings", "The coupling schemes on the same hand motion.");
  command->footer(
      "direct: all bodies at the haptic rate. sub-world: the paper's method. static: the proxy moves among frozen\n"
      "members. interpolation: the device feels the global world's proxy, interpolated over a cycle; a spring holds "
      "that\n"
      "proxy to the device, as part of the global step. K: its stiffness, marked ! where the scene's is not stable at\n"
      "this ratio and the largest stable one stands in for it, in the direct run beside it too. plane, planes: a "
      "plane\n"
      "with friction for the contact that presses most, or for each contact point, new ones blended in over a cycle.\n"
      "linearised: the force and its Jacobian.\n"
      "Errors are against direct coupling, over windows of 25 cycles (at least 200 ms) that start from its state.\n"
      "stable: a second run has the hand in the loop, with the device's encoder and delay. Its force stays below 1.5 "
      "times\n"
      "the direct coupling's peak plus 1 N. While the hand holds, the force shakes by at most 0.2 N more than with "
      "direct\n"
      "coupling and keeps at least half of that one's mean. At the end every body stands, and the energy never exceeds "
      "the\n"
      "direct run's by more than 10 % of the energy at play ('stands' and 'energy at play' as with --whole, below).\n"
      "Virtual time: the same options give the same figures.\n" +
      std::string(kWholeRunsHelp) +
      "\nExample:\n  tactus experiment couplings --quick\n  tactus experiment couplings --csv couplings.csv --page "
      "couplings.html");
  add_coupling_options(*command, *options);
  command->callback(
      [options, &exit_code] { exit_code = run_coupling_experiment(*options, experiment::every_coupling()); });
}

}  // namespace tactus::tools
