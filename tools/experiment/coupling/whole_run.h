// Compares whole runs of a coupling with the direct one, from rest to the end, with the scene's hand script.
//
// Windows of 200 ms start from the direct run's state and cannot detect a border that makes a scene collapse within two
// seconds. In a whole run, force, poses and energy are compared over its full length. Thread: one. Virtual time: the
// same request, the same bits. Frame: world. Units: SI.
#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rt/base/result.h"
#include "rt/haptics/coupling_limits.h"
#include "sim/exchange/extraction.h"
#include "sim/model/scene.h"
#include "tools/experiment/coupling/scheme.h"
#include "tools/experiment/progress.h"

namespace tactus::experiment {

enum class WholeRunHand : std::uint8_t {
  kClosed,  // the arm in the loop of the run itself
  kDirect,  // the arm's motion of the direct run
  kNone,    // no device: the coupling's damper alone is on the proxy, in this run and in its direct run
};

struct WholeRunRequest {
  std::vector<sim::Scene> scenes;
  std::vector<Scheme> schemes;       // compared with the direct coupling
  std::vector<unsigned> members{0};  // caps; 0: the scene's
  double seconds{10};
  std::vector<WholeRunHand> hands{WholeRunHand::kClosed};
  // Compares, first for each scene, the direct run with two others: one whose proxy starts displaced by kApart_m, and
  // one of kFinerSteps times as many sub-steps. A coupling's error below the first difference is chance; below the
  // second, it is within the discretisation error of the direct run itself.
  bool floor{false};
  static constexpr double kApart_m = 1e-6;
  static constexpr unsigned kFinerSteps = 2;
  sim::CutOrder order{sim::CutOrder::kBestFirst};
  bool keep_bodies{false};  // at the start and at the end of both runs, in the rows
};

// A body stands if, at the end, its centre is within half of its smallest extent of its position in the direct run, and
// its rotation relative to the direct run is less than kTurnedOver (a ball may roll). Not counted are bodies that are
// not at rest at the end of the direct run (faster than kAtRest), or that fall in it: rotated by kTurnedOver, or
// lowered by half of their smallest extent since the start.
struct StandingRule {
  static constexpr double kShareOfExtent = 0.5;
  static constexpr double kTurnedOver_rad = 0.5;
  static constexpr double kAtRest_m_per_s = 0.01;
};

// Applies the rule to the moving bodies, in the order of their ids.
struct Standing {
  unsigned standing{0};      // bodies that the rule counts
  std::vector<BodyId> fell;  // of these
  double most_off_share{
      0};  // largest displacement of these from the direct run, relative to the body's smallest extent
};
Standing judge_standing(std::span<const physics::Body> start, std::span<const physics::Body> direct_end,
                        std::span<const physics::Body> end);

// Energy at the border and at the device over a whole run, with sign.
struct EnergyAccount {
  double device_J{0};       // work of the device on the proxy's spring: -wrench . velocity, summed
  double border_work_J{0};  // done on members by the border, with push-out (rt/physics/push_out.h)
  double corrected_J{0};    // given to members by corrections
  double tank_J{0};         // in the border's tank at the end
  double spent_share{0};    // of the ticks in which the tank is empty
  double global_work_J{0};  // done on members by outside bodies in the global steps, with push-out
  double imposed_J{0};      // change of the global world's energy when members' states are imposed
  double returned_J{0};     // same, when impulses are returned to outside bodies
};

struct WholeRunRow {
  std::string scene;
  Scheme scheme;
  unsigned members{0};
  haptics::CouplingGains gains;  // world units: the scene's, lowered to the limit; also of the direct run
  double seconds{0};
  WholeRunHand hand{WholeRunHand::kClosed};
  double apart_m{0};                            // above 0: a direct run that started displaced by this
  unsigned sub_steps_times{1};                  // above 1: a direct run of so many times as many sub-steps
  double force_error{0};                        // RMS(F - F_direct) / RMS(F_direct), over the whole run
  std::array<double, 4> force_error_quarter{};  // per quarter, relative to the RMS of F_direct over the whole run
  double force_rms_N{0};                        // of the direct run
  double pose_off_m{0},
      pose_off_most_m{0};    // largest distance of a body from the direct run: at the end, at any synchronisation
  double pose_off_share{0};  // at the end, of bodies at rest in the direct run, relative to their smallest extent
  double drift_m{0};         // pose_off_m at the end minus at three quarters of the run
  double deepest_m{0}, direct_deepest_m{0};  // overlap of two bodies, at any tick of the haptic side or global step
  double kinetic_J{0};                       // largest kinetic energy of all bodies
  double kinetic_over_work{0};  // kinetic_J divided by the hand's work plus the potential energy released until then
  // Largest excess of kinetic + potential energy over start + hand's work. Includes the work of motors, kinematic
  // bodies, attraction and restitution, in both runs.
  double energy_gain_J{0};
  double direct_energy_gain_J{0};  // same, of the direct run
  // Largest rise of kinetic + potential energy - hand's work above an earlier value; also of the direct run.
  double energy_rise_J{0}, direct_energy_rise_J{0};
  // Same above an earlier value plus what was stored then: in springs of contacts and joints, and in the border, taken
  // from bodies of one world and not yet given to those of the other. Rule: sim/energy_balance.h.
  double energy_unexplained_J{0}, direct_energy_unexplained_J{0};
  double energy_at_play_J{0};  // sum of the hand's absolute work + weight of each body times its extent
  double direct_kinetic_J{0};  // largest kinetic energy of the direct run
  unsigned standing{0};        // bodies that the rule counts, standing in the direct run
  unsigned fallen{0};          // of these
  bool stands{true};
  EnergyAccount account;
  // If the request keeps them: the moving bodies, in the order of their ids.
  std::vector<physics::Body> start, end, direct_end;
};

// The scene with `times` as many sub-steps in a tick; its global step is unchanged.
sim::Scene with_finer_steps(sim::Scene scene, unsigned times);

// Error, one line: a scene does not fit the schemes.
Result<std::vector<WholeRunRow>> run_whole(const WholeRunRequest& request, const Progress& progress);

// The keys with which the JSON of a run or of its windows begins: scene, coupling, border, ratio, members, gains.
nlohmann::ordered_json run_json(const std::string& scene, const Scheme& scheme, unsigned members,
                                const haptics::CouplingGains& gains);

std::string_view name_of(WholeRunHand hand) noexcept;

std::string whole_table(std::span<const WholeRunRow> rows);
std::string whole_csv(std::span<const WholeRunRow> rows);                   // units in the header
nlohmann::ordered_json whole_rows_json(std::span<const WholeRunRow> rows);  // an array of objects

}  // namespace tactus::experiment
