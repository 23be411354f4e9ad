// Judges a run by one table of rules, for `tactus run`, `tactus timing` and `tactus scene check`.
//
// A run is `bad` if the program or the simulation is at fault: the hand did not feel what the scene defines, or the
// program lost ticks to its own work. It is `degraded` if its quality is reduced: the machine did not keep up, or
// something was used up or left out. Only `bad` gives exit status 1: the machine's delays are reported but do not fail
// the run.
//
//   rule        degraded above      bad above           figure; why there
//   fault       -                   0                   a fault is latched at the end
//   faults      0                   -                   faults that were cleared: without force meanwhile
//   samples     1 % of the ticks    -                   no valid sample of the device
//   own-work    -                   0                   ticks lost to the program's own work
//   scene       -                   0                   problems reported by `tactus scene check`
//   overlap     10 %                50 %                deepest overlap / thickness of the thinner body. Less for a
//                                                       soft contact; above a half it is resolved to the far side
//   energy      10 % and 5 mJ       25 % and 20 mJ      unexplained energy / largest kinetic energy or hand's work.
//                                                       A border may supply a tenth (hard case 33). Only if the energy
//                                                       account is complete (sim/energy_balance.h)
//   border      1 % of the ticks    10 % of the ticks   the energy tank of the border is empty (border-spent): the
//                                                       members are braked
//   capacity    0                   -                   entries left out: contacts, pairs, border points
//   deadlines   1 in 10 000, and 1  -                   ticks late because of the machine, and skipped deadlines
//   clock       1 % and 4 cycles    -                   lag of the global clock behind the haptic clock
//   set-up      0                   -                   real-time privileges and kernel: lines with FAIL
//   tape        0                   -                   ticks not written because of the disk or full buffers
// Thread: normal, after the run. Pure.
#pragma once

#include <cstdint>
#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "sim/loader/scene_report.h"

namespace tactus::session {

struct RunSummary;

enum class Level : std::uint32_t { kGood = 0, kDegraded = 1, kBad = 2 };
const char* name_of(Level level) noexcept;  // one word: good, degraded, bad

// Result of one rule. Good up to `degraded_above` or, if that is infinite, up to `bad_above`.
struct RunRuling {
  std::string rule, figure, unit;
  double measured{0};
  double degraded_above{std::numeric_limits<double>::infinity()}, bad_above{std::numeric_limits<double>::infinity()};
  std::string found, remedy;  // the finding and what to do about it; for a rule that is not good
  bool machine{false};        // caused by the machine, not by the program

  Level level() const noexcept;
};

struct RunVerdict {
  std::vector<RunRuling> rulings;  // all that apply, good ones too, in the order of the table

  Level level() const noexcept;  // the worst
  int exit_code() const noexcept { return level() == Level::kBad ? 1 : 0; }
  std::string line() const;  // good; DEGRADED: the first reason; BAD: the same
  std::string text() const;  // a line for each reason, with figure, limit and remedy; empty if good
};

RunVerdict judge(const RunSummary& summary);
// Applies the rule `scene` only, to a scene without a run.
RunVerdict judge(const sim::SceneReport& report);
// All rules except those based on a clock: for `tactus timing`, which has its own rows for deadlines and own work.
std::vector<RunRuling> judge_simulation(const RunSummary& summary);

// Accepted number of late ticks and skipped deadlines per 10 000: one, and one in a shorter run.
double most_lost_of_10000(std::uint64_t ticks) noexcept;

nlohmann::json to_json(const RunVerdict& verdict);  // an array: one object for each rule, its figure and its limits

}  // namespace tactus::session
