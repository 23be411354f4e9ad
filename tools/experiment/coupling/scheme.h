// A coupling scheme as an experiment runs it. Thread: [any].
#pragma once

#include <string_view>

#include "rt/haptics/coupling_scheme.h"
#include "rt/physics/border/border_contact.h"
#include "sim/loader/choice_names.h"

namespace tactus::experiment {

struct Scheme {
  haptics::CouplingScheme coupling{haptics::CouplingScheme::kSubWorld};
  physics::BorderMode border{physics::BorderMode::kGhost};  // of the sub-world coupling
  unsigned ratio{8};                                        // ticks per global step
};

// "-" where the coupling has none.
inline std::string_view name_of_border(const Scheme& scheme) {
  return scheme.coupling == haptics::CouplingScheme::kSubWorld ? sim::name_of(scheme.border) : "-";
}

}  // namespace tactus::experiment
