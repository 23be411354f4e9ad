// Whole runs of a coupling beside the direct one, from rest to the end, with the hand of the scene's own script.
//
// Windows of 200 ms start from the direct run's state, so they cannot see a border that tears a scene down in two
// seconds. A whole run can: force, poses and energy are compared over its full length. Two hands: `closed`, the arm
// in the loop of the run itself, and `direct`, the arm's motion of the direct run. Thread: one. Virtual time: the same
// request, the same bits. Frame: world. Units: SI.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "rt/base/result.h"
#include "rt/haptics/coupling_limits.h"
#include "sim/exchange/extraction.h"
#include "sim/model/scene.h"
#include "tools/experiment/coupling/scheme.h"
#include "tools/experiment/progress.h"

namespace tactus::experiment {

struct WholeRunRequest {
  std::vector<sim::Scene> scenes;
  std::vector<Scheme> schemes;       // beside the direct coupling
  std::vector<unsigned> members{0};  // caps; 0: the scene's
  double seconds{10};
  bool hand_of_direct{false};  // also with the direct run's hand
  // First, for each scene, the direct run beside another that starts with its proxy kApart_m aside: how far two direct
  // runs go apart. What a coupling is off by less than that cannot be told from chance.
  bool floor{false};
  static constexpr double kApart_m = 1e-6;
  sim::CutOrder order{sim::CutOrder::kBestFirst};
  bool keep_bodies{false};  // at the start and at the end of both runs, in the rows
};

// A body stands where, at the end, its centre is within half of its smallest extent of where the direct run has it,
// and it is turned by less than kTurnedOver against it (a ball may roll). Not counted are bodies that the direct run
// itself does not leave at rest (faster than kAtRest at its end), or that fall there: turned by kTurnedOver, or sunk by
// half of their smallest extent since the start.
struct StandingRule {
  static constexpr double kShareOfExtent = 0.5;
  static constexpr double kTurnedOver_rad = 0.5;
  static constexpr double kAtRest_m_per_s = 0.01;
};

// The rule, on bodies that move, in the order of their ids.
struct Standing {
  unsigned standing{0};      // bodies that count
  std::vector<BodyId> fell;  // of these
  double most_off_share{0};  // farthest of these from where the direct run has it, of its smallest extent
};
Standing judge_standing(std::span<const physics::Body> start, std::span<const physics::Body> direct_end,
                        std::span<const physics::Body> end);

struct WholeRunRow {
  std::string scene;
  Scheme scheme;
  unsigned members{0};
  haptics::CouplingGains gains;  // world units: the most that the coupling bears of the scene's; the direct run's too
  double seconds{0};
  bool closed_hand{true};
  double apart_m{0};                            // above 0: a direct run that started so much aside
  double force_error{0};                        // RMS(F - F_direct) / RMS(F_direct), over the whole run
  std::array<double, 4> force_error_quarter{};  // of the quarter, over the RMS of F_direct of the whole run
  double force_rms_N{0};                        // of the direct run
  double pose_off_m{0}, pose_off_most_m{0};  // farthest body from the direct run's: at the end, at any synchronisation
  double pose_off_share{0};  // at the end, of bodies that the direct run leaves at rest: of their smallest extent
  double drift_m{0};         // farthest body from the direct run's at the end, less the same at three quarters
  double deepest_m{0}, direct_deepest_m{0};  // overlap of two bodies, at any tick of the haptic side or global step
  double kinetic_J{0};                       // largest kinetic energy of all bodies
  double kinetic_over_work{0};               // that, over the hand's work and the potential energy released till then
  double energy_gain_J{0};                   // largest excess of kinetic + potential energy over start + hand's work
  double direct_energy_gain_J{0};            // same, of the direct run
  double energy_at_play_J{0};                // hand's work without sign + weight of each body times its extent
  double direct_kinetic_J{0};                // largest kinetic energy of the direct run
  unsigned standing{0};                      // bodies that the rule counts: the direct run leaves them standing
  unsigned fallen{0};                        // of these
  bool stands{true};
  double border_work_J{0};  // done on members by the border
  // Where the request keeps them: the bodies that move, in the order of their ids.
  std::vector<physics::Body> start, end, direct_end;
};

// One line where a scene does not go with the schemes.
Result<std::vector<WholeRunRow>> run_whole(const WholeRunRequest& request, const Progress& progress);

std::string whole_table(std::span<const WholeRunRow> rows);
std::string whole_csv(std::span<const WholeRunRow> rows);  // units in the header

}  // namespace tactus::experiment
