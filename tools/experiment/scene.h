// The scenes of the experiments: cubes dropped on a jittered grid into an open box, one description for every engine.
//
// Frame: z up, the box's floor is z = 0 and its middle the origin. Units: SI. Thread: [any]; plain values.
// The same name gives the same bits on every machine: the jitter comes from a generator of our own.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rt/base/spatial.h"

namespace tactus::experiment {

struct Cube {
  double edge_m;
  double mass_kg;
  Vec3d position;  // of the centre
  Quatd rotation;  // world_from_cube
};

struct Wall {  // a fixed box along the axes
  Vec3d half_extents_m, position;
};

// A rod that stirs the heap: an upright box that circles about the middle, the same way in every engine.
struct Paddle {
  Vec3d half_extents_m;
  double height_m;  // of its centre
  double radius_m;  // of its circle
  double speed_rad_per_s;

  Vec3d position_at(double time_s) const noexcept;
  Vec3d velocity_at(double time_s) const noexcept;
};

struct BoxScene {
  std::string name;
  double step_s{1e-2};
  double settle_s{5};
  std::uint32_t timed_steps{500};
  double friction{0.5};
  double gravity_m_per_s2{9.81};  // downwards
  std::vector<Cube> cubes;
  std::vector<Wall> walls;  // floor and four sides
  std::optional<Paddle> paddle;
};

struct PileSpec {
  std::uint32_t cubes{64};
  double step_s{1e-3};
  bool stirred{false};
  double smallest_edge_m{0.1}, largest_edge_m{0.1};  // sizes are drawn evenly in the logarithm
  std::uint32_t layers{8};
  std::uint64_t seed{1};
};

// Mass is that of 1000 kg/m^3: 1 kg at 0.1 m.
BoxScene make_pile(std::string name, const PileSpec& spec);

// The names that `peers` takes, in the order of its table.
const std::vector<std::string_view>& scene_names();
// One of them; none where there is no such name. `quick`: settles 1 s, a fifth of the timed steps.
std::optional<BoxScene> make_scene(std::string_view name, bool quick);

}  // namespace tactus::experiment
