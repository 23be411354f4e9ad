// The step's parameters for the border. Units: SI. Thread: [any], a plain value.
#pragma once

#include "rt/physics/border/border_contact.h"
#include "rt/physics/border/work_limit.h"
#include "rt/physics/contact/contact_row.h"

namespace tactus::physics {

struct BorderStep {
  BorderRule rule;
  double h;              // s: of a sub-step
  double impulse_scale;  // of the impulses of the last step, for the warm start
  SweepRule<double> sweep;
  bool friction;
};

}  // namespace tactus::physics
