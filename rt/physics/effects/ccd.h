// Effect ccd: continuous collision detection for the proxy, so that a fast hand cannot push it through a thin plate.
//
// Contacts are found up to StepSettings::max_margin ahead in a step, 20 mm: enough for 20 m/s in a tick. If the proxy
// may move further, this effect tests it in every sub-step, from the present poses, against all bodies within reach.
// Where it would pass a surface, an impulse on both bodies, as of a contact's speculative row, slows it down so that
// the sub-step ends at touch. Momentum is kept and kinetic energy falls. For a slow proxy the cost is one comparison.
// Not against meshes: their triangles are not available here.
// Units: SI. Thread: [rt], the owner of the World. Bound: B + F boxes a step, kMaxNear pairs of bodies a sub-step, each
// of kMaxParts^2 pairs of parts; beyond that the nearest are tested, and the rest are counted as dropped pairs.
#pragma once

#include "rt/physics/collision/manifold.h"
#include "rt/physics/effects/stage.h"
#include "rt/physics/shapes/shape_lists.h"

namespace tactus::physics {

class ContinuousCollision : public Stateless {
 public:
  static constexpr std::uint32_t kMaxNear = 16;

  struct Setup {
    BodyId proxy{kNoBody};
    ShapeLists shapes{};  // of the world's shapes. Must outlive the world
    bool used() const noexcept { return proxy != kNoBody; }
  };
  ContinuousCollision(const Setup& setup, const Capacities&) noexcept : setup_(setup) {}
  void register_stages(StageTable& table) noexcept;

 private:
  struct Near {
    std::uint32_t slot{0};
    bool fixed{false};
    double distance{};  // m: between the bounding spheres, a lower bound of the distance of the shapes
  };

  void look_around(StageContext& c) noexcept;
  void add(StageContext& c, const Near& near) noexcept;
  void hold_back(StageContext& c) noexcept;
  void hold_back_at(const Near& near, const Manifold& manifold, StageContext& c) noexcept;

  Setup setup_;
  std::uint32_t proxy_{0};              // slot
  FixedVector<Near, kMaxNear> near_{};  // of this step
};

}  // namespace tactus::physics
