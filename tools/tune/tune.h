// tactus tune SCENE: the most accurate setting of a scene that this PC bears.
//
// Accuracy is measured in virtual time: the scene's own hand, windows of 200 ms in which it touches, against all bodies
// at 1 kHz with 16 sub-steps and two relax sweeps (tools/experiment/coupling/setting_cost.h). Time is CPU time on this
// core, scaled by what a short real run of the scene as it is written takes: a loop that sleeps between its ticks finds
// its caches cold. The choice is then run for real, and taken back a step where it does not hold. Thread: the main one.
// Bound: scenes of at most haptics::kMaxMembers moving bodies; 1 kHz.
#pragma once

#include <atomic>

#include "tools/experiment/progress.h"
#include "tools/tune/search.h"

namespace tactus::tune {

struct TuneRequest {
  std::string file;  // for the command that is printed
  sim::Scene scene;
  session::RunOptions run;  // cpu, priority
  Limits limits;            // bodies are filled in
  double verify_s{5};       // of each real run
  bool quick{false};        // two windows in the hand's first three seconds, instead of four in its first six
};

// One tick in a hundred may have less in a real run, one cycle in a hundred: the machine's gaps count there too.
inline constexpr double kMostMissed = 0.01;

// A real run of a setting.
struct RealRun {
  double duration_s{0};
  double tick_us_p50{0}, tick_us_p99{0}, tick_us_max{0};  // computing
  double reduced_share{0};                                // ticks with fewer sub-steps, or cut
  double restrained_share{0}, late_share{0};              // cycles with fewer members; whose global step was late
  std::uint64_t lost{0};                                  // ticks, to the program's own work
  bool degraded{false};                                   // without a real-time privilege
  bool holds() const {
    return lost == 0 && reduced_share <= kMostMissed && restrained_share <= kMostMissed && late_share <= kMostMissed;
  }
};

struct FurtherStep {
  Notch notch;
  Trial trial;
  bool fits{false};
};

struct TuneReport {
  std::string file, scene, scene_hash;
  unsigned bodies{0}, windows{0};
  Limits limits;
  double core_factor{1};  // a tick in the loop / the same tick in a row
  Trial written, chosen;
  bool fits{false};
  RealRun real;  // of the chosen one
  std::vector<FurtherStep> further;
  unsigned trials{0};
};

// One line: why there is nothing to tune, or what the system refuses.
Result<TuneReport> run_tune(const TuneRequest& request, const experiment::Progress& progress,
                            const std::atomic<bool>& stop);

std::string command_of(const TuneReport& report);  // the options that `tactus run` has for it
std::string snippet_of(const TuneReport& report);  // [simulation], all of it
std::string tune_text(const TuneReport& report);
std::string tune_json(const TuneReport& report);

}  // namespace tactus::tune
