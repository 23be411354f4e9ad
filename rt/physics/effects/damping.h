// Effect damping: every moving body loses speed in proportion to it.
//
// Implicit Euler of dv/dt = -c v: v' = v / (1 + h c), the same for the angular velocity: never turns a motion round,
// whatever c and h. Units: SI. Thread: [rt], the owner of the World. Bound: linear in bodies.
#pragma once

#include "rt/physics/effects/stage.h"

namespace tactus::physics {

template <class T>
class Damping : public Stateless {
 public:
  struct Setup {
    T linear_per_s{}, angular_per_s{};  // c
    bool used() const noexcept { return linear_per_s > T(0) || angular_per_s > T(0); }
  };
  Damping(const Setup& setup, const Capacities&) noexcept : setup_(setup) {}
  void enter(StageTable<T>& table) noexcept { table.template add<&Damping::slow_down>(Phase::kForces, *this); }

 private:
  void slow_down(StageContext<T>& c) noexcept;

  Setup setup_;
};

}  // namespace tactus::physics
