// Exports a tape into files that other programs read: CSV, HDF5, MCAP, Perfetto's JSON, in one walk through the tape.
//
// Ticks are copied from the tape, bit by bit. Bodies are those of the sub-world: the tape is replayed for their poses.
// Thread: normal. Bound: constant memory (sink.h). Errors: one line each, what is accepted in it.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "rt/base/result.h"

namespace tactus::exporting {

struct ExportOptions {
  std::string tape;
  std::string csv, hdf5, mcap, perfetto;                 // files; empty: not asked for
  double from_s{0};                                      // simulated time: ticks that end at or after it
  double to_s{std::numeric_limits<double>::infinity()};  // and before it
  std::vector<std::string> signals;                      // columns or groups; empty: all, for Perfetto kDrawnBest
  double world_Hz{0};                                    // frames of bodies per second of simulated time; 0: none
  bool overwrite{false};
};

struct ExportReport {
  std::uint64_t rows{0};     // ticks exported
  std::uint64_t columns{0};  // of each
  std::uint64_t bytes{0};    // of all files
  std::uint64_t bodies{0};   // states of bodies exported, all frames together
  std::uint64_t frames{0};
  std::uint64_t lost_ticks{0};          // by gaps and damage, where the tick numbers show it
  std::uint64_t different_ticks{0};     // replayed for the bodies, with another result than the tape's
  std::uint64_t unreplayable_ticks{0};  // no bodies there: between a gap or damage and the next keyframe
  std::string damage;                   // the first damage, in one line; empty: none
  std::string warning;                  // all that makes the export less than the tape was meant to be; empty: nothing
  std::vector<std::string> files;

  bool good() const noexcept { return damage.empty() && different_ticks == 0; }
};

// True: this build has libhdf5.
bool has_hdf5() noexcept;

// What the options themselves have wrong; the tape is not opened.
Status check(const ExportOptions& options);

// Error: wrong options, no tape, or a file that cannot be written; files that are not complete are removed. `machine`
// is set where the machine cannot do it. `progress`: the completed share, 0 to 1.
Result<ExportReport> export_tape(const ExportOptions& options, const std::function<void(double)>& progress,
                                 bool& machine);

}  // namespace tactus::exporting
