// The subcommands of `tactus experiment`, one file each. Thread: [setup].
#pragma once

namespace CLI {
class App;
}

namespace tactus::tools {

// Each adds its subcommand, which sets `exit_code` when it runs.
void add_accuracy_cost(CLI::App& experiment, int& exit_code);
void add_capacity(CLI::App& experiment, int& exit_code);
void add_couplings(CLI::App& experiment, int& exit_code);
void add_energy_loss(CLI::App& experiment, int& exit_code);
void add_hard_cases(CLI::App& experiment, int& exit_code);
void add_peers(CLI::App& experiment, int& exit_code);
void add_scaling(CLI::App& experiment, int& exit_code);
void add_stability_map(CLI::App& experiment, int& exit_code);
void add_effects(CLI::App& experiment, int& exit_code);

}  // namespace tactus::tools
