// tactus sweep FILE: many runs in virtual time. The work is the Python module's; here are the options.
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "tools/experiment/shared_files.h"
#include "tools/json_text.h"
#include "tools/tactus/commands.h"
#include "tools/tactus/help_texts.h"
#include "tools/tactus/in_range.h"
#include "tools/tactus/output_option.h"
#include "tools/tactus/python_module.h"

namespace tactus::tools {
namespace {

struct SweepCommand {
  std::string file, folder, csv, hdf5, unit, scheduler;
  unsigned workers{0};
  bool fresh{false}, list{false}, collect{false}, trust_network{false}, json{false};
};

// Replaces this process by the sweep's Python module; returns only on failure.
int run_sweep(const SweepCommand& command) {
  std::error_code none;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", none);
  const std::filesystem::path module = python_module_folder(program);
  if (module.empty())
    return complain(
        "tactus sweep: needs the Python module, which is built where Debian's pybind11-dev and python3-dev are",
        kExitMachineCannot);
  setenv("PYTHONPATH", module.c_str(), 1);
  const nlohmann::ordered_json options{{"program", program.string()},
                                       {"scenes", experiment::shared_file("scenes").string()},
                                       {"file", command.file},
                                       {"folder", command.folder},
                                       {"csv", command.csv},
                                       {"hdf5", command.hdf5},
                                       {"unit", command.unit},
                                       {"workers", command.workers},
                                       {"fresh", command.fresh},
                                       {"list", command.list},
                                       {"collect", command.collect},
                                       {"scheduler", command.scheduler},
                                       {"trust_network", command.trust_network},
                                       {"json", command.json}};
  const std::string text = json_text(options);
  execl(kPython, kPython, "-m", "tactus.sweep", text.c_str(), static_cast<char*>(nullptr));
  return complain(fmt::format("tactus sweep: {}: {}", kPython, std::strerror(errno)), kExitMachineCannot);
}

}  // namespace

CLI::App* add_sweep_command(CLI::App& program, int& exit_code) {
  auto command = std::make_shared<SweepCommand>();
  CLI::App* app = program.add_subcommand(
      "sweep", "Run a scene in virtual time with every combination of values, and write one table.");
  app->footer(
      "The file names a scene, and lists of values; every combination is run:\n"
      "  scene = \"press.toml\"              # from the file's folder; else the scene of tactus with this name\n"
      "  duration_s = 2\n"
      "  seeds = 3                          # of injected faults: 1, 2, 3; or a list\n"
      "  [options]                          # of tactus run, as the library names them: coupling, rate_Hz, ratio, ...\n"
      "  coupling = [\"sub-world\", \"static\"]\n"
      "  [keys]                             # of the scene; of a list by number, from 1: body.2.mass_kg\n"
      "  \"coupling.stiffness_N_per_m\" = {from = 500, to = 1500, steps = 3}\n"
      "  [keep]\n"
      "  summary = [\"hand/force_max_N\"]    # of the object of tactus run --json\n"
      "  columns = [\"force_z_N:rms\"]       # as tactus run --figures\n"
      "Each unit is one process and one file in the sweep's folder, named by the hash of scene, options, version and\n"
      "instruction set. A file is written whole or not at all, and a finished unit is not run again. A unit that\n"
      "fails is a row with its message. After Ctrl-C the same command continues.\n"
      "Exit status: 0 good; 1 a unit failed or is not finished; 2 bad usage or file; 3 no Python module.\n\n"
      "Examples:\n  tactus sweep tools/examples/gains.toml --workers 2 --csv gains.csv\n"
      "  tactus sweep gains.toml --list | parallel && tactus sweep gains.toml --collect --csv gains.csv");
  app->add_option("FILE", command->file, "sweep file (TOML), see below")->required();
  app->add_option("--workers", command->workers, std::string(help::kWorkers) + "; default: one per core")
      ->check(in_range(1, 1024));
  app->add_option("--scheduler", command->scheduler, help::kScheduler)->excludes("--workers");
  app->add_flag("--trust-network", command->trust_network, help::kTrustNetwork);
  app->add_option("--folder", command->folder,
                  "folder of the results; default: FILE's name with .sweep, in the working directory");
  add_output(*app, "--csv", command->csv, exporting::OutputKind::kCsv,
             "write the table of all finished units to this CSV file");
  add_output(*app, "--hdf5", command->hdf5, exporting::OutputKind::kHdf5,
             "write the table of all finished units to this HDF5 file: the dataset units, a field for each column\n"
             "(needs python3-h5py)");
  CLI::Option* fresh = app->add_flag("--fresh", command->fresh, "discard the results of finished units");
  app->add_flag("--list", command->list, "print the command of each unit that is not finished, and run nothing");
  app->add_option("--unit", command->unit, "name of the only unit to run, as --list prints it");
  app->add_flag("--collect", command->collect, "collect the results of finished units, and run nothing")
      ->excludes(fresh);
  app->add_flag("--json", command->json, help::kJson);
  app->callback([command, &exit_code] { exit_code = run_sweep(*command); });
  return app;
}

}  // namespace tactus::tools
