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
      "members. interpolation: the device feels the global world's proxy, interpolated, and holds it there by a "
      "spring\n"
      "that the global step solves; K is the most that it bears at the ratio, where the scene's is more (marked !), "
      "and\n"
      "the direct run beside it has the same. plane, planes: a plane with friction for the contact that presses most,\n"
      "or for each contact point, new ones blended in over a cycle. linearised: the force and its Jacobian. Errors "
      "are\n"
      "against the direct coupling, over windows of 25 cycles, at least 200 ms, that start from its state. stable is "
      "judged with the hand\n"
      "in the loop, the device's own encoder and delay: no force beyond 1.5 times the direct coupling's peak and 1 N\n"
      "more; while the hand holds, no more than 0.2 N of shaking beyond its own, and at least half its force (nothing "
      "has\n"
      "given way); at the end every body stands, and there never is more energy than the direct run has by 10 % of "
      "the\n"
      "energy at play. Both words as with --whole, below. Virtual time: the same options, the same figures.\n" +
      std::string(kWholeRunsHelp) +
      "\nExample:\n  tactus experiment couplings --quick\n  tactus experiment couplings --csv couplings.csv --page "
      "couplings.html");
  add_coupling_options(*command, *options);
  command->callback(
      [options, &exit_code] { exit_code = run_coupling_experiment(*options, experiment::every_coupling()); });
}

}  // namespace tactus::tools
