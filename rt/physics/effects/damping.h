// Effect damping: every moving body is slowed in proportion to its velocity.
//
// Implicit Euler of dv/dt = -c v: v' = v / (1 + h c), the same for the angular velocity; never reverses a motion, for
// any c and h. Units: SI. Thread: [rt], the owner of the World. Bound: linear in bodies.
#pragma once

#include "rt/physics/effects/stage.h"

namespace tactus::physics {

class Damping : public Stateless {
 public:
  struct Setup {
    double linear_per_s{}, angular_per_s{};  // c
    bool used() const noexcept { return linear_per_s > 0.0 || angular_per_s > 0.0; }
  };
  Damping(const Setup& setup, const Capacities&) noexcept : setup_(setup) {}
  void register_stages(StageTable& table) noexcept { table.add<&Damping::slow_down>(Phase::kForces, *this); }

 private:
  void slow_down(StageContext& c) noexcept;

  Setup setup_;
};

}  // namespace tactus::physics
