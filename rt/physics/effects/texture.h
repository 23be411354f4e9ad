// Effect texture: the grain of a surface, felt by the hand that slides over it.
//
// A grained body has the height h(q) = height x (sin kx + sin ky + sin kz), k = 2 pi / wavelength, q = (x, y, z) the
// place in its own frame. Where the proxy presses on it with N, climbing the height costs N h: so the hand feels
//   F = -N grad h, without its part along the normal,
// and nothing else in the world does (StepReport::felt; the passivity controller comes after it). At a steady N that is
// the force of a potential: what a groove takes on the way in it gives back on the way out, whatever the path. Finer
// than the ticks resolve it is not felt: from a quarter of the rate of ticks on it fades, at half of it it is gone.
// Stateless. Units: SI. Thread: [rt], the owner of the World. Bound: linear in contacts. Source: Minsky and others
// 1990, feeling and seeing: lateral forces by the gradient of a height map.
#pragma once

#include "rt/physics/effects/stage.h"

namespace tactus::physics {

struct Grain {
  double height_m{};      // of each of the three waves
  double wavelength_m{};  // not zero
};

class Texture : public Stateless {
 public:
  struct Setup {
    BodyId proxy{kNoBody};
    std::span<const Grain> by_id{};  // those beyond the end, or of height 0, are smooth. Must outlive the world
    bool used() const noexcept { return proxy != kNoBody && !by_id.empty(); }
  };
  Texture(const Setup& setup, const Capacities&) noexcept : setup_(setup) {}
  void enter(StageTable& table) noexcept { table.add<&Texture::feel>(Phase::kFinish, *this); }

 private:
  void feel(StageContext& c) noexcept;

  Setup setup_;
};

}  // namespace tactus::physics
