/// \file
/// Summary and verdict of a run, as `tactus run` prints them.
///
/// Thread: any normal one. Units: in the names.
#pragma once

#include <string>

#include "tactus/tick.h"

namespace tactus {

/// Result of the rules in tools/session/README.md, *What a summary means*.
enum class Verdict : std::uint32_t {
  kGood = 0,      ///< the hand felt what the scene defines
  kDegraded = 1,  ///< reduced quality: the machine did not keep up, or something was left out
  kBad = 2,       ///< the program or the simulation was at fault, or a fault is latched
};

/// Statistics and verdict of a run so far.
struct Summary {
  Verdict verdict{Verdict::kGood};  ///< the worst of all rules
  std::uint64_t ticks{0};           ///< done
  std::uint64_t contact_ticks{0};   ///< in which the proxy touched something
  std::uint64_t faults{0};          ///< latched so far, cleared ones included
  std::uint64_t overruns{0};        ///< ticks past their deadline; 0 in virtual time
  double max_force_N{0};            ///< on the hand
  double mean_force_N{0};           ///< on the hand, over all ticks
  std::uint64_t state_hash{0};      ///< see Session::state_hash
  std::string text;                 ///< readable text, as `tactus run` prints it, with reasons and remedies
  std::string json;                 ///< as `tactus run --json` prints it, units in the keys
};

}  // namespace tactus
