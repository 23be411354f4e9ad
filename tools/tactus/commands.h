// The subcommands of the program, one source file each. Every function adds its subcommand to the program and sets
// `exit_code` when it runs: 0 good; 1 it ran and the verdict is bad; 2 bad usage or input; 3 the machine cannot run it.
//
// Thread: main.
#pragma once

#include <CLI/CLI.hpp>

#include <string>

namespace tactus::tools {

inline constexpr int kExitGood = 0, kExitVerdictBad = 1, kExitBadInput = 2, kExitMachineCannot = 3;

CLI::App* add_run_command(CLI::App& program, int& exit_code);
CLI::App* add_hil_command(CLI::App& program, int& exit_code);
CLI::App* add_device_command(CLI::App& program, int& exit_code);
CLI::App* add_replay_command(CLI::App& program, int& exit_code);
CLI::App* add_export_command(CLI::App& program, int& exit_code);
CLI::App* add_import_command(CLI::App& program, int& exit_code);
CLI::App* add_view_command(CLI::App& program, int& exit_code);
CLI::App* add_scene_command(CLI::App& program, int& exit_code);
void add_scene_keys_command(CLI::App& scene, int& exit_code);  // below `scene`
CLI::App* add_doctor_command(CLI::App& program, int& exit_code);
CLI::App* add_timing_command(CLI::App& program, int& exit_code);
CLI::App* add_tune_command(CLI::App& program, int& exit_code);
CLI::App* add_config_command(CLI::App& program, int& exit_code);
CLI::App* add_sweep_command(CLI::App& program, int& exit_code);
CLI::App* add_control_command(CLI::App& program, int& exit_code);
CLI::App* add_experiment_command(CLI::App& program, int& exit_code);

// Reports why a command ends: one line on stderr, "tactus: " and the text. With --json and an exit status of 2 or 3
// also the only object on stdout, with the key `error`. Returns `exit_code`, so that a command can return it.
int complain(const std::string& text, int exit_code);
// Same, for a text with one line per mistake.
int complain_of_each(const std::string& lines, int exit_code);
// Same as complain(), for an error after the object has been printed: only the line on stderr.
int complain_after(const std::string& text, int exit_code);

// Writes `text` to `path`; nothing if the path is empty. Returns the exit status; reports a file that cannot be
// written.
int write_file(const std::string& path, const std::string& text);

}  // namespace tactus::tools
