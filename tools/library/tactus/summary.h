/// \file
/// What a run amounts to, and whether it was good: the summary of `tactus run`.
///
/// Thread: any normal one. Units: in the names.
#pragma once

#include <string>

#include "tactus/tick.h"

namespace tactus {

/// By one table of rules, the README's *What a summary means*.
enum class Verdict : std::uint32_t {
  kGood = 0,      ///< what was felt is what the scene says
  kDegraded = 1,  ///< worth less than it was meant to be: the machine did not keep up, or something was left out
  kBad = 2,       ///< the program or the simulation was at fault, or a fault is latched
};

/// What a run amounts to so far.
struct Summary {
  Verdict verdict{Verdict::kGood};  ///< the worst of all rules
  std::uint64_t ticks{0};           ///< done
  std::uint64_t contact_ticks{0};   ///< in which the proxy touched something
  std::uint64_t faults{0};          ///< latched so far, those that were taken back included
  std::uint64_t overruns{0};        ///< ticks past their deadline; 0 in virtual time
  double max_force_N{0};            ///< on the hand
  double mean_force_N{0};           ///< on the hand, over all ticks
  std::uint64_t state_hash{0};      ///< see Session::state_hash
  std::string text;                 ///< for people: what `tactus run` prints, with reasons and cures
  std::string json;                 ///< what `tactus run --json` prints, units in the keys
};

}  // namespace tactus
