// Compares couplings with the direct one on the same hand motion: `tactus experiment energy-loss` and `couplings`.
//
// For each scene and seed, one run uses direct coupling with the hand in the loop. Then, for each coupling, border and
// ratio, windows of 200 ms start from that run's state, contact impulses included, with that run's hand motion.
// Stability is tested in separate runs: from rest, with the hand in the loop and the device's encoder and delay. A
// coupling that is not stable with the scene's stiffness uses the largest allowed one (tools/session/scheme_gains.h)
// and is compared with a direct run of the same stiffness, so that the error is that of the coupling alone; its row
// lists the stiffness. Thread: one.
// Virtual time: the same request, the same bits.
#pragma once

#include <string>
#include <vector>

#include "rt/haptics/coupling_limits.h"
#include "sim/exchange/extraction.h"
#include "tools/experiment/coupling/coupling_cases.h"
#include "tools/experiment/coupling/energy_measures.h"
#include "tools/experiment/coupling/scheme.h"
#include "tools/experiment/coupling/whole_run.h"
#include "tools/experiment/progress.h"

namespace tactus::experiment {

struct StudyRequest {
  std::vector<CouplingCase> cases;
  std::vector<Scheme> schemes;
  unsigned seeds{20};
  unsigned members{0};  // cap; 0: the case's
  sim::CutOrder order{sim::CutOrder::kBestFirst};
  bool quick{false};  // two windows per seed instead of six
};

// Results of a run from rest with the hand in the loop and the device's encoder and delay.
struct HandInLoop {
  double peak_N{0};       // largest force
  double shake_N{0};      // 20 to 500 Hz while the hand holds
  double hold_N{0};       // mean force while the hand holds
  unsigned fallen{0};     // bodies that stand in the direct run and not here (StandingRule)
  double energy_gain{0};  // excess over initial energy plus hand's work, minus that of the direct run, as a share of
                          // the energy at play
};

// Figures of the windows of one hand, to show their spread between hands.
struct SeedFigures {
  double force_error{0}, loss{0}, gain{0}, sync_step_N{0}, hold_vibration_N{0};
};

// Results of one coupling on one scene; fractions, unless the name has a unit.
struct StudyRow {
  std::string scene;
  Scheme scheme;
  unsigned members{0};                             // cap
  haptics::CouplingGains gains;                    // world units; also used by the direct run that it is compared with
  bool lowered{false};                             // less stiff than the scene's
  Deviation energy, worst_instant, speed_squared;  // L1, L2, L3, over the windows in which the hand moves
  bool at_rest{false};                             // L1, L2: shares of the reference energy (energy_measures.h)
  double force_error{0};                           // RMS(F - F_direct) / RMS(F_direct), over all windows
  double force_error_hold{0}, force_error_moving{0};
  double force_error_worst{0};         // of the windows
  double sync_step_N{0};               // 95 % quantile of the steps of F - F_direct at synchronisations
  double hold_vibration_N{0};          // std of F - F_direct, 20 to 500 Hz, ideal encoder; median of the hold windows
  double hold_vibration_worst_N{0};    // of the hold windows
  double hold_vibration_encoder_N{0};  // same median, with the device's encoder
  bool stable{true};
  HandInLoop loop;
  std::vector<SeedFigures> by_seed;
  std::vector<double> spectrum;  // of F - F_direct in hold windows, mean power by line [N^2]
};

// Properties of one scene, and the divergence of two direct runs that start 1 um apart.
struct StudyScene {
  std::string name;
  unsigned bodies{0}, members{0}, component{0}, contact_points{0};
  double contact_share{0};  // share of the windows' ticks with proxy contact
  double force_rms_N{0};
  double apart_force_error{0};
  Deviation apart_energy;
  HandInLoop loop;  // of the direct coupling
};

struct StudyReport {
  std::vector<StudyRow> rows;
  std::vector<StudyScene> scenes;
  std::vector<WholeRunRow> whole;  // in addition to the windows, see whole_run.h
  unsigned seeds{0}, windows{0};   // a seed
  double window_s{0}, line_Hz{0};  // the shortest window: kWindowCycles cycles, or that
};

// Error, one line: a scene cannot be loaded or does not fit the schemes.
Result<StudyReport> run_coupling_study(const StudyRequest& request, const Progress& progress);

// Criteria of stability, relative to the direct coupling: peak force at most 1.5 times its peak plus 1 N; while the
// hand holds, at most 0.2 N more vibration between 20 and 500 Hz, and at least half its force, so that nothing has
// given way; every body stands at the end (StandingRule); the energy never exceeds that of the direct run by more than
// kMaxEnergyGain of the energy at play.
inline constexpr double kMaxEnergyGain = 0.1;
bool is_stable(const HandInLoop& loop, const HandInLoop& direct);

std::string study_table(const StudyReport& report);
std::string study_json(const StudyReport& report);  // {"rows": [...], "scenes": [...]}
std::string study_csv(const StudyReport& report);   // units in the header

}  // namespace tactus::experiment
