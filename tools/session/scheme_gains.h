// The coupling's gains of a run: the scene's, lowered if the coupling scheme is not stable with them.
//
// Every scheme has the device's own limit (rt/haptics/coupling_limits.h); gains above the allowed share of it are
// refused as an error of the scene. The interpolation coupling has a lower limit, which falls with the ratio
// (rt/haptics/interpolation_limit.h). Scenes are written for the sub-world coupling, so with interpolation the
// stiffness is lowered to the allowed value and the run reports it. With --keep-gains the run is refused instead, and
// the message states the limit. The same holds where several hands may hold one body: shared_limit.h. Thread: normal.
// Units: SI; gains of the scene are world units, those at the hand are motion_scale^2 of them for translation.
#pragma once

#include <string>

#include "rt/haptics/coupling_limits.h"
#include "sim/model/scene.h"
#include "tools/session/run_options.h"

namespace tactus::session {

struct SchemeGains {
  haptics::CouplingGains gains;  // world units: what the run uses
  haptics::CouplingGains asked;  // the scene's
  // World units: above these stiffnesses the scheme is unstable with the scene's damping; infinite if the scheme adds
  // no limit to the device's. Allowed: haptics::kAllowedStiffnessShare of them.
  double stiffness_limit_N_per_m{0}, stiffness_limit_Nm_per_rad{0};

  bool lowered() const noexcept {
    return gains.stiffness_N_per_m < asked.stiffness_N_per_m || gains.stiffness_Nm_per_rad < asked.stiffness_Nm_per_rad;
  }
};

SchemeGains gains_of(const sim::Scene& scene, const RunOptions& options, const haptics::DeviceProperties& device);

// Error, one line: the gains are beyond the limit of the device or, with --keep-gains, of the scheme, or no lower
// stiffness makes them stable.
Status check_gains(const sim::Scene& scene, const RunOptions& options, const haptics::DeviceProperties& device);

// "stiffness 1500 -> 905 N/m, ...": empty if nothing was lowered.
std::string lowered_text(const SchemeGains& gains);
// "the most that ...": why it was.
std::string lowered_why(const RunOptions& options, unsigned ratio);

}  // namespace tactus::session
