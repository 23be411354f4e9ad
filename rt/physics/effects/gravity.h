// Effect gravity: every moving body falls, by its gravity_scale.
//
// v += h g, semi-implicit. The acceleration is the step's (StepSettings), for bounds need it too. Units: SI.
// Thread: [rt], the owner of the World. Bound: linear in bodies.
#pragma once

#include "rt/physics/effects/stage.h"

namespace tactus::physics {

class Gravity : public Stateless {
 public:
  struct Setup {
    bool on{true};
    bool used() const noexcept { return on; }
  };
  Gravity(const Setup&, const Capacities&) noexcept {}
  void enter(StageTable& table) noexcept { table.add<&Gravity::fall>(Phase::kForces, *this); }

 private:
  void fall(StageContext& c) noexcept;
};

}  // namespace tactus::physics
