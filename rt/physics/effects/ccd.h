// Effect ccd: continuous collision for the proxy. However fast the hand is, the proxy passes through no thin plate.
//
// Contacts are looked for as far ahead as StepSettings::max_margin in a step, 20 mm: enough for 20 m/s in a tick.
// Where the proxy might go further, this effect looks in every sub-step at all bodies that it could reach, from where
// both are then, and slows it down where it would pass a surface: an impulse on both, as a contact's speculative row
// gives, so that the sub-step ends where they touch. Momentum is kept and kinetic energy falls. A proxy that is slower
// pays for one comparison. Not against meshes: those are solid, and their triangles are not at hand here.
// Units: SI. Thread: [rt], the owner of the World. Bound: B + F boxes a step, kMostNear pairs a sub-step; beyond that
// the nearer ones are looked at, and the rest counted as pairs left out.
#pragma once

#include "rt/physics/effects/stage.h"
#include "rt/physics/shapes/hull.h"

namespace tactus::physics {

class ContinuousCollision : public Stateless {
 public:
  static constexpr std::uint32_t kMostNear = 16;

  struct Setup {
    BodyId proxy{kNoBody};
    Hulls hulls{};  // of the world's shapes. Must outlive the world
    bool used() const noexcept { return proxy != kNoBody; }
  };
  ContinuousCollision(const Setup& setup, const Capacities&) noexcept : setup_(setup) {}
  void enter(StageTable& table) noexcept;

 private:
  struct Near {
    std::uint32_t slot{0};
    bool fixed{false};
    double distance{};  // m, of the balls that hold the shapes; the least that it may be
  };

  void look_around(StageContext& c) noexcept;
  void add(StageContext& c, const Near& near) noexcept;
  void hold_back(StageContext& c) noexcept;

  Setup setup_;
  std::uint32_t proxy_{0};               // slot
  FixedVector<Near, kMostNear> near_{};  // of this step
};

}  // namespace tactus::physics
