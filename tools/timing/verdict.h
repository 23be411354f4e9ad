// What a timing run is held against, figure by figure, and what follows.
//
// "bad" says that the program itself is at fault: a tick lost to its own work, or a page fault of the haptic thread.
// "machine" says that the program kept its promise and the machine did not. Thread: normal. Pure.
#pragma once

#include <string>
#include <vector>

#include "tools/timing/books.h"

namespace tactus::timing {

struct VerdictRow {
  std::string figure, unit;
  double measured{0}, limit{0};  // good up to the limit
  bool ours{false};              // the program's to keep, not the machine's
  bool good() const { return measured <= limit; }
};

// Limits are shares of the period, as given in verdict.cpp with their reasons.
std::vector<VerdictRow> judge(const Books& books);

enum class TimingVerdict { kGood, kMachine, kBad };
TimingVerdict verdict_of(const std::vector<VerdictRow>& rows);
const char* name_of(TimingVerdict verdict);  // one word

}  // namespace tactus::timing
