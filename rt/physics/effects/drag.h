// Effect drag: a fluid that fills the world, at rest or in uniform flow, resists motion with the square of the speed.
//
// Implicit Euler of du/dt = -k |u| u, u the body's velocity relative to the fluid: u' = u / (1 + k |u| h). For a body
// without other forces this is exact: 1 / |u'| = 1 / |u| + k h. k = density x drag coefficient x area across the flow /
// (2 mass). Acts at the centre; rotation is not resisted. Units: SI. Thread: [rt], the owner of the World. Bound:
// linear in bodies.
#pragma once

#include "rt/physics/effects/stage.h"

namespace tactus::physics {

class Drag : public Stateless {
 public:
  struct Setup {
    std::span<const double> per_m{};  // k by body id; bodies beyond the end have none. Must outlive the world
    Vec3d flow{};                     // m/s, of the fluid
    bool used() const noexcept { return !per_m.empty(); }
  };
  Drag(const Setup& setup, const Capacities&) noexcept : setup_(setup) {}
  void register_stages(StageTable& table) noexcept { table.add<&Drag::resist>(Phase::kForces, *this); }

 private:
  void resist(StageContext& c) noexcept;

  Setup setup_;
};

}  // namespace tactus::physics
