// Rough ground for the experiments: a triangle mesh of waves and roughness over a square, in four walls. Gravity is
// tilted and turns, so that what lies on the ground rolls about and stays.
//
// Frame: z up, the centre of the square is the origin. Units: SI. Thread: [any]; plain values. The same seed gives the
// same bits on every machine.
#pragma once

#include "rt/base/spatial.h"
#include "sim/geometry/mesh_builder.h"
#include "sim/random.h"

namespace tactus::experiment {

struct TerrainSpec {
  std::uint32_t cells{100};   // along each side; each has two triangles
  double cell_m{0.1};         // its width
  double wave_m{0.15};        // amplitude of the waves, along x and along y
  double wave_length_m{2.5};  // of the waves
  double roughness_m{8e-3};   // largest shift of a corner, up or down
};

sim::TriangleSoup make_terrain(const TerrainSpec& spec, sim::Random& random);

// Adds two triangles for each cell of a grid, facing +z. The corners go first along x, then along y.
void add_grid_triangles(std::uint32_t x_cells, std::uint32_t y_cells, sim::TriangleSoup& soup);

// Direction of gravity that is tilted from -z by an angle and turns about z.
struct TurningGravity {
  double tilt_rad{0}, speed_rad_per_s{0};

  Vec3d direction(double time_s) const noexcept {
    const SinCos turn = sin_cos(speed_rad_per_s * time_s), tilt = sin_cos(tilt_rad);
    return {tilt.sin * turn.cos, tilt.sin * turn.sin, -tilt.cos};
  }
};

}  // namespace tactus::experiment
