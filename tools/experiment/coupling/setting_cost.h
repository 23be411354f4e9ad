// One setting of solver, sub-world and border, on the windows of a reference run: its force error and its computing
// time.
//
// The reference is a direct run with many more sub-steps and a second relax sweep: the error includes those of the
// coupling and of the solver. Times are CPU times of one thread, separate for the haptic side and the global world.
// Thread: one, on one core.
// Bound: scenes of at most haptics::kMaxMembers moving bodies.
#pragma once

#include <span>
#include <vector>

#include "hal/profiles.h"
#include "rt/haptics/coupling/coupling_scheme.h"
#include "rt/physics/step.h"
#include "rt/physics/sweep_precision.h"
#include "sim/exchange/extraction.h"
#include "tools/experiment/coupling/force_measures.h"
#include "tools/experiment/coupling/reference_run.h"
#include "tools/experiment/coupling/scheme.h"

namespace tactus::experiment {

struct CostSetting {
  unsigned sub_steps{4}, relax_sweeps{1};
  physics::FrictionSweeps friction{physics::FrictionSweeps::kAuto};
  double contact_Hz{250};
  unsigned members{64};
  Scheme scheme;
  sim::CutOrder order{sim::CutOrder::kBestFirst};
  physics::SweepPrecision precision{physics::SweepPrecision::kSingle};  // of the global world
  friend bool operator==(const CostSetting&, const CostSetting&) = default;
};

// The scene and the options of a run with this setting.
sim::Scene with(sim::Scene scene, const CostSetting& setting);
session::RunOptions options_of(const CostSetting& setting);  // with the sub-world coupling

// Records the reference with the scene's own hand and all bodies at the haptic rate. `ratios`: those of the settings to
// be measured.
ReferenceRun record_fine(const sim::Scene& scene, const hal::DeviceProfile& profile, std::size_t ticks,
                         std::span<const WindowPlace> places, std::span<const unsigned> ratios);

// Sums over windows, of one hand or of all.
struct SettingSums {
  ForceError error;
  EnergyDeviation energy;
  std::vector<double> vibration, steps;     // N: of the hold windows; at synchronisations
  std::vector<double> ticks_us, global_us;  // time of a tick of the haptic side; of a global step

  void add(const SettingSums& other);
};

// Adds the results of a setting on the reference's windows. Its ratio must be one of `ratios` of record_fine.
void measure_setting(const sim::Scene& scene, const hal::DeviceProfile& profile, const CostSetting& setting,
                     const ReferenceRun& reference, std::span<const unsigned> ratios, SettingSums& sums);

}  // namespace tactus::experiment
