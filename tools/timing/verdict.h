// Judges a timing run: rows on its times, and the rules of `tactus run` (tools/session/verdict.h) on the simulation,
// its scene and the set-up.
//
// "bad": the program is at fault: a tick lost to its own work, a page fault of the haptic thread, or a bad simulation.
// "machine": the program met its limits and the machine did not, or the run was otherwise degraded; its row states the
// reason. Thread: normal. Pure.
#pragma once

#include <string>
#include <vector>

#include "tools/session/verdict.h"
#include "tools/timing/tick_statistics.h"

namespace tactus::timing {

struct VerdictRow {
  std::string figure, unit;
  double measured{0}, limit{0};  // good up to the limit
  bool ours{false};              // responsibility of the program, not of the machine
  std::string found{};           // from the rules of a run: text if it is not good
  bool good() const { return measured <= limit; }
};

// Limits are shares of the period, as given in verdict.cpp with their reasons.
std::vector<VerdictRow> judge(const TickStatistics& statistics);
// The rules of a run as rows: `bad` sets `ours`, `degraded` does not.
std::vector<VerdictRow> rows_of(const std::vector<session::RunRuling>& rulings);

enum class TimingVerdict { kGood, kMachine, kBad };
TimingVerdict verdict_of(const std::vector<VerdictRow>& rows);
const char* name_of(TimingVerdict verdict);  // one word

}  // namespace tactus::timing
