// The coupling's gains of a run: the scene's, lowered where the coupling scheme cannot be stable with them.
//
// Every scheme has the limit of the device itself (rt/haptics/coupling_limits.h); gains beyond what it allows are an
// error of the scene and refused. The interpolation coupling has a lower one, which falls with the ratio
// (rt/haptics/interpolation_limit.h): scenes are written for the sub-world, so there the stiffness is lowered to what
// is allowed, and the run says so. Who wants the scene's own or none gives --keep-gains, and is told the limit. Thread:
// normal. Units: SI; gains of the scene are world units, those at the hand are motion_scale^2 of them for translation.
#pragma once

#include <string>

#include "rt/haptics/coupling_limits.h"
#include "sim/model/scene.h"
#include "tools/session/run_options.h"

namespace tactus::session {

struct SchemeGains {
  haptics::CouplingGains gains;  // world units: what the run uses
  haptics::CouplingGains asked;  // the scene's
  // World units: above these the scheme is not stable with the scene's damping; infinite where it has no limit of its
  // own. What is allowed is haptics::kAllowedStiffnessShare of them.
  double stiffness_limit_N_per_m{0}, stiffness_limit_Nm_per_rad{0};

  bool lowered() const noexcept {
    return gains.stiffness_N_per_m < asked.stiffness_N_per_m || gains.stiffness_Nm_per_rad < asked.stiffness_Nm_per_rad;
  }
};

SchemeGains gains_of(const sim::Scene& scene, const RunOptions& options, const haptics::DeviceProperties& device);

// One line on gains that the device or, with --keep-gains, the scheme cannot hold; also on those that no lower
// stiffness helps.
Status check_gains(const sim::Scene& scene, const RunOptions& options, const haptics::DeviceProperties& device);

// "stiffness 1500 -> 905 N/m, ...": empty where nothing was lowered.
std::string lowered_text(const SchemeGains& gains);

}  // namespace tactus::session
