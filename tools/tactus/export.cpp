// tactus export TAPE: a tape's ticks and bodies as files that other programs read.
#include "tools/export/export.h"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "tools/export/columns.h"
#include "tools/json_report.h"
#include "tools/tactus/commands.h"
#include "tools/tactus/help_texts.h"

namespace tactus::tools {
namespace {

struct ExportCommand {
  exporting::ExportOptions options;
  bool json{false};
};

void print_text(const ExportCommand& command, const exporting::ExportReport& report) {
  fmt::print("tactus export: {} ({} ticks, {} columns)\n", command.options.tape, report.rows, report.columns);
  if (report.frames > 0) fmt::print("  bodies               {} states in {} frames\n", report.bodies, report.frames);
  for (const std::string& file : report.files) fmt::print("  written              {}\n", file);
  fmt::print("  bytes                {}\n", report.bytes);
}

int run_export(const ExportCommand& command) {
  const bool terminal = !command.json && isatty(STDERR_FILENO) != 0;
  bool machine = false;
  const auto result = exporting::export_tape(
      command.options,
      [&](double share) {
        if (terminal) fmt::print(stderr, "\rexporting {:3.0f} % ", 100 * share);
      },
      machine);
  if (terminal) fmt::print(stderr, "\r\033[K");
  if (!result.ok()) return complain("tactus export: " + result.message(), machine ? kExitMachineCannot : kExitBadInput);
  const exporting::ExportReport& report = result.value();
  if (command.json) {
    const nlohmann::ordered_json object{
        {"tape", command.options.tape},    {"rows", report.rows},     {"columns", report.columns},
        {"bytes", report.bytes},           {"bodies", report.bodies}, {"frames", report.frames},
        {"lost_ticks", report.lost_ticks}, {"files", report.files},   {"warning", report.warning}};
    fmt::print("{}\n", report_text(object, 2));
  } else {
    print_text(command, report);
  }
  if (!report.warning.empty()) fmt::print(stderr, "tactus: warning: {}\n", report.warning);
  return report.good() ? kExitGood : kExitVerdictBad;
}

}  // namespace

CLI::App* add_export_command(CLI::App& program, int& exit_code) {
  auto command = std::make_shared<ExportCommand>();
  exporting::ExportOptions& o = command->options;
  CLI::App* app = program.add_subcommand("export", "Convert a tape to CSV, HDF5, MCAP or a trace for Perfetto.");
  app->footer(
      "Ticks are copied from the tape, bit by bit; the name of a column includes its unit. With --world the tape is\n"
      "replayed, and the poses of the sub-world's bodies are written too: as CSV to a second file, FILE.bodies.csv.\n"
      "Where a record is damaged, the program prints what is lost and continues after it.\n"
      "Exit status: 0 good; 1 a part of the tape is lost, or its replay differs; 2 no such tape, bad options; 3 a\n"
      "file cannot be written.\n\n"
      "Examples:\n"
      "  tactus export my.tape --csv my.csv --from 2 --to 3 --signals force,proxy,counts\n"
      "  tactus export my.tape --hdf5 my.h5 --mcap my.mcap --world 60");
  app->add_option("TAPE", o.tape, help::kTape)->required();
  app->add_option("--csv", o.csv, "write the ticks to this CSV file");
  app->add_option("--hdf5", o.hdf5, "write the ticks to this HDF5 file, for MATLAB, Octave, h5py, pandas, Julia, R");
  app->add_option("--mcap", o.mcap, "write the ticks to this MCAP file, for Foxglove, Lichtblick, PlotJuggler");
  app->add_option(
      "--perfetto", o.perfetto,
      "write a trace for Perfetto to this file: counters, cycles, faults; without --signals the groups force,\n"
      "counts, energy and times");
  app->add_option("--from", o.from_s, "start of the exported part, in simulated time [s]; 0 or more")
      ->capture_default_str();
  app->add_option("--to", o.to_s,
                  "end of the exported part, exclusive, in simulated time [s]; default: the end of the tape");
  app->add_option("--signals", o.signals,
                  fmt::format("columns or groups of columns, separated by commas; default: all. Groups:\n{}",
                              fmt::join(exporting::group_names(), ", ")))
      ->delimiter(',');
  app->add_option("--world", o.world_Hz,
                  "number of frames of the bodies per second of simulated time [Hz]; at most one per tick; 0: none")
      ->capture_default_str();
  app->add_flag("--overwrite", o.overwrite, help::kOverwrite);
  app->add_flag("--json", command->json, help::kJson);
  app->callback([command, &exit_code] { exit_code = run_export(*command); });
  return app;
}

}  // namespace tactus::tools
