#include "tools/experiment/engine.h"

#include <algorithm>
#include <cmath>

namespace tactus::experiment {

#if !TACTUS_HAS_BULLET
std::unique_ptr<Engine> make_bullet(const BoxScene&, const EngineOptions&) { return nullptr; }
#endif
#if !TACTUS_HAS_ODE
std::unique_ptr<Engine> make_ode(const BoxScene&, const EngineOptions&) { return nullptr; }
#endif

#if !TACTUS_HAS_MUJOCO
std::unique_ptr<Engine> make_mujoco(const BoxScene&, const EngineOptions&) { return nullptr; }
bool mujoco_takes(const BoxScene&) { return false; }
#endif

const std::vector<EngineKind>& engine_kinds() {
  constexpr bool kBullet = TACTUS_HAS_BULLET != 0, kOde = TACTUS_HAS_ODE != 0, kMujoco = TACTUS_HAS_MUJOCO != 0;
  // Name, package, tuned, maker, available, iterations, which scenes.
  static const std::vector<EngineKind> kinds{
      {"tactus", "", false, make_tactus, true},
      {"bullet", "libbullet-dev", false, make_bullet, kBullet},
      {"bullet-tuned", "libbullet-dev", true, make_bullet, kBullet},
      {"ode", "libode-dev", false, make_ode, kOde},
      {"ode-tuned", "libode-dev", true, make_ode, kOde},
      {"mujoco", "libmujoco-dev", false, make_mujoco, kMujoco, 0, mujoco_takes},
      {"mujoco-tuned", "libmujoco-dev", true, make_mujoco, kMujoco, 0, mujoco_takes},
  };
  return kinds;
}

const std::vector<EngineKind>& compared_kinds() {
  static const std::vector<EngineKind> kinds = [] {
    constexpr bool kBullet = TACTUS_HAS_BULLET != 0, kOde = TACTUS_HAS_ODE != 0;
    std::vector<EngineKind> all = engine_kinds();
    all.push_back({.name = "bullet-tuned-4",
                   .package = "libbullet-dev",
                   .tuned = true,
                   .make = make_bullet,
                   .available = kBullet,
                   .iterations = 4});
    all.push_back({.name = "bullet-tuned-40",
                   .package = "libbullet-dev",
                   .tuned = true,
                   .make = make_bullet,
                   .available = kBullet,
                   .iterations = 40});
    all.push_back({.name = "ode-tuned-40",
                   .package = "libode-dev",
                   .tuned = true,
                   .make = make_ode,
                   .available = kOde,
                   .iterations = 40});
    return all;
  }();
  return kinds;
}

double residual_speed(const std::vector<CubeState>& cubes) {
  double sum = 0;
  for (const CubeState& cube : cubes) sum += norm_squared(cube.velocity);
  return cubes.empty() ? 0 : std::sqrt(sum / static_cast<double>(cubes.size()));
}

}  // namespace tactus::experiment
