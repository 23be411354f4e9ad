// Effect texture: the surface profile of a body, rendered to the hand that slides over it.
//
// A textured body has the height h(q) = height x (sin kx + sin ky + sin kz), k = 2 pi / wavelength, q = (x, y, z) the
// position in its own frame. Under the normal force N of the proxy the potential is N h, so the hand receives
//  F = -N grad h, without its part along the normal,
// which acts on no body (StepReport::hand_wrench; it passes the passivity controller). At constant N the force is
// conservative. Waves too fine for the tick rate are not rendered: the force fades out from a quarter of the tick rate
// on and is zero at half of it.
// Stateless. Units: SI. Thread: [rt], the owner of the World. Bound: linear in contacts. Source: Minsky and others
// 1990, feeling and seeing: lateral forces by the gradient of a height map.
#pragma once

#include "rt/physics/effects/stage.h"

namespace tactus::physics {

struct Grain {
  double height_m{};      // amplitude of each of the three waves
  double wavelength_m{};  // not zero
};

class Texture : public Stateless {
 public:
  struct Setup {
    BodyId proxy{kNoBody};
    std::span<const Grain> by_id{};  // bodies beyond the end, or of height 0, are smooth. Must outlive the world
    bool used() const noexcept { return proxy != kNoBody && !by_id.empty(); }
  };
  Texture(const Setup& setup, const Capacities&) noexcept : setup_(setup) {}
  void register_stages(StageTable& table) noexcept { table.add<&Texture::feel>(Phase::kFinish, *this); }

 private:
  void feel(StageContext& c) noexcept;

  Setup setup_;
};

}  // namespace tactus::physics
