// tactus tune SCENE: finds the most accurate setting of a scene that this PC can run.
//
// Accuracy is measured in virtual time: the scene's own hand, windows of 200 ms in which it is in contact, compared
// with all bodies at 1 kHz with 16 sub-steps and two relax sweeps (tools/experiment/coupling/setting_cost.h). Time is
// CPU time on this core, scaled by a short real-time run of the scene as written, because a loop that sleeps between
// ticks finds cold caches. The chosen setting is verified in a real-time run and reduced by one step if it fails.
// Thread: the main one.
// Bound: scenes of at most haptics::kMaxMembers moving bodies; 1 kHz.
#pragma once

#include <atomic>

#include "tools/experiment/progress.h"
#include "tools/session/verdict.h"
#include "tools/tune/search.h"

namespace tactus::tune {

struct TuneRequest {
  std::string file;  // for the command that is printed
  sim::Scene scene;
  session::RunOptions run;  // cpu, priority
  Limits limits;            // `bodies` is filled in by run_tune
  double verify_s{5};       // of each real-time run
  bool quick{false};        // two windows in the hand's first three seconds, instead of four in its first six
};

// Accepted share of ticks and of cycles that are reduced in a real-time run, because interruptions by the machine are
// included.
inline constexpr double kMaxMissed = 0.01;

// Results of a real-time run of a setting.
struct RealRun {
  double duration_s{0};
  double tick_us_p50{0}, tick_us_p99{0}, tick_us_max{0};  // computing
  double reduced_share{0};                                // ticks with fewer sub-steps, or cut
  double restrained_share{0}, late_share{0};              // share of cycles with fewer members; with a late global step
  std::uint64_t lost{0};                                  // ticks, ticks lost to the program's own work
  bool degraded{false};                                   // without a real-time privilege
  bool holds() const {
    return lost == 0 && reduced_share <= kMaxMissed && restrained_share <= kMaxMissed && late_share <= kMaxMissed;
  }
};

struct FurtherStep {
  SettingStep change;
  Trial trial;
  bool fits{false};
};

struct TuneReport {
  std::string file, scene, scene_hash;
  unsigned bodies{0}, windows{0};
  Limits limits;
  double core_factor{1};  // time of a tick in the loop divided by that of the same tick back to back
  Trial written, chosen;
  bool fits{false};
  session::RunVerdict of_scene;  // before any run, by the rule of `tactus scene check`
  RealRun real;                  // of the chosen one
  std::vector<FurtherStep> further;
  unsigned trials{0};

  bool good() const { return fits && real.holds() && of_scene.level() != session::Level::kBad; }
};

// Error, one line: why there is nothing to tune, or what the system refuses.
Result<TuneReport> run_tune(const TuneRequest& request, const experiment::Progress& progress,
                            const std::atomic<bool>& stop);

std::string command_of(const TuneReport& report);  // the options of `tactus run` for it
std::string snippet_of(const TuneReport& report);  // the complete [simulation] table
std::string tune_text(const TuneReport& report);
std::string tune_json(const TuneReport& report);

}  // namespace tactus::tune
