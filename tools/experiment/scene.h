// The scenes of the experiments: cubes, or bodies of other shapes, dropped on a jittered grid into an open box; one
// description for all engines.
//
// Frame: z up, the floor of the box is z = 0, its centre the origin. Units: SI. Thread: [any]; plain values.
// The same name gives the same bits on every machine: the jitter comes from the project's own generator.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rt/base/spatial.h"
#include "rt/physics/shapes/hull.h"
#include "tools/experiment/stirrer.h"
#include "tools/experiment/terrain.h"

namespace tactus::experiment {

enum class Form : std::uint8_t { kCube, kSphere, kCapsule, kPlate, kHull };

struct Cube {  // a body of any form, about as large as a cube of that edge
  double edge_m;
  double mass_kg;
  Vec3d position;  // of the centre
  Quatd rotation;  // world_from_cube
  Form form{Form::kCube};
  std::uint32_t hull{0};  // of the scene's hulls; kHull only
};

struct Wall {  // a fixed box
  Vec3d half_extents_m, position;
  Quatd rotation{};  // world_from_wall
};

struct BoxScene {
  std::string name;
  double step_s{1e-2};
  double settle_s{5};
  std::uint32_t timed_steps{500};
  double friction{0.5};
  double gravity_m_per_s2{9.81};  // downwards
  std::vector<Cube> cubes;
  std::vector<physics::Hull> hulls;
  std::vector<Wall> walls;  // the floor, then four sides: upright, or sloping like a bowl in a stirred scene
  std::optional<Stirrer> stirrer;
  std::optional<sim::BuiltMesh> terrain;  // fixed; its pose in the world is the mesh's in the frame of the corners
  std::optional<TurningGravity> turning;  // of gravity; empty: straight down

  Vec3d gravity_at(double time_s) const noexcept {  // m/s^2
    return gravity_m_per_s2 * (turning ? turning->direction(time_s) : Vec3d{0, 0, -1});
  }
};

std::uint32_t rods_of(const BoxScene& scene) noexcept;

struct BoxPileSpec {
  std::uint32_t cubes{64};
  double step_s{1e-3};
  bool stirred{false};
  double smallest_edge_m{0.1}, largest_edge_m{0.1};  // sizes are log-uniform
  std::vector<Form> forms{};                         // drawn for each body; empty: cubes
  std::uint32_t hull_vertices{20};                   // of each hull, all on a sphere
  std::uint32_t layers{8};
  std::uint64_t seed{1};
};

// Mass is that of 1000 kg/m^3: 1 kg at 0.1 m.
BoxScene make_pile(std::string name, const BoxPileSpec& spec);

// The names that `peers` takes, in the order of its table.
const std::vector<std::string_view>& scene_names();
// Makes one of them; empty for an unknown name. `quick`: settles 1 s, a fifth of the timed steps.
std::optional<BoxScene> make_scene(std::string_view name, bool quick);

}  // namespace tactus::experiment
