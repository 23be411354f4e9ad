// What a timing run is held against, figure by figure, and what follows: rows on the clock, and the rules of
// tools/session/verdict.h on the simulation, its scene and the set-up, which are those of `tactus run`.
//
// "bad" says that the program itself is at fault: a tick lost to its own work, a page fault of the haptic thread, or a
// simulation that is bad. "machine" says that the program kept its promise and the machine did not, or that the run
// was degraded otherwise: its row says by what. Thread: normal. Pure.
#pragma once

#include <string>
#include <vector>

#include "tools/session/verdict.h"
#include "tools/timing/tick_statistics.h"

namespace tactus::timing {

struct VerdictRow {
  std::string figure, unit;
  double measured{0}, limit{0};  // good up to the limit
  bool ours{false};              // the program's to keep, not the machine's
  std::string found{};           // by the rules of a run: what to say where it is not good
  bool good() const { return measured <= limit; }
};

// Limits are shares of the period, as given in verdict.cpp with their reasons.
std::vector<VerdictRow> judge(const TickStatistics& books);
// The rules of a run as rows: `bad` is ours, `degraded` is not.
std::vector<VerdictRow> rows_of(const std::vector<session::Ruling>& rulings);

enum class TimingVerdict { kGood, kMachine, kBad };
TimingVerdict verdict_of(const std::vector<VerdictRow>& rows);
const char* name_of(TimingVerdict verdict);  // one word

}  // namespace tactus::timing
