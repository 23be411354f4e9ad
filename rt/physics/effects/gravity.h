// Effect gravity: accelerates every moving body by gravity times its gravity_scale.
//
// v += h g, semi-implicit. g is in StepSettings, because the bounds need it too. Units: SI.
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
  void register_stages(StageTable& table) noexcept { table.add<&Gravity::fall>(Phase::kForces, *this); }

 private:
  void fall(StageContext& c) noexcept;
};

}  // namespace tactus::physics
