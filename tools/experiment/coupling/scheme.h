// A coupling scheme as an experiment runs it. Thread: [any].
#pragma once

#include "rt/haptics/coupling_scheme.h"
#include "rt/physics/border/border_contact.h"

namespace tactus::experiment {

struct Scheme {
  haptics::CouplingScheme coupling{haptics::CouplingScheme::kSubWorld};
  physics::BorderMode border{physics::BorderMode::kGhost};  // of the sub-world coupling
  unsigned ratio{8};                                        // ticks per global step
};

}  // namespace tactus::experiment
