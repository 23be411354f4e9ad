#include "tools/experiment/terrain.h"

namespace tactus::experiment {

void add_grid_triangles(std::uint32_t x_cells, std::uint32_t y_cells, sim::TriangleSoup& soup) {
  const std::uint32_t side = x_cells + 1;
  for (std::uint32_t j = 0; j < y_cells; ++j) {
    for (std::uint32_t i = 0; i < x_cells; ++i) {
      const std::uint32_t a = j * side + i, b = a + 1, c = a + side, d = c + 1;
      soup.triangles.push_back({a, b, d});
      soup.triangles.push_back({a, d, c});
    }
  }
}

sim::TriangleSoup make_terrain(const TerrainSpec& spec, sim::Random& random) {
  constexpr double kTwoPi = 6.28318530717958648;
  sim::TriangleSoup soup;
  const std::uint32_t side = spec.cells + 1;
  const double half = 0.5 * spec.cells * spec.cell_m;
  for (std::uint32_t j = 0; j < side; ++j) {
    for (std::uint32_t i = 0; i < side; ++i) {
      const double x = i * spec.cell_m - half, y = j * spec.cell_m - half;
      const double waves = sin_cos(kTwoPi * x / spec.wave_length_m).sin + sin_cos(kTwoPi * y / spec.wave_length_m).sin;
      const double rough = spec.roughness_m * random.symmetric();
      soup.corners.push_back({x, y, spec.wave_m * waves + rough});
    }
  }
  add_grid_triangles(spec.cells, spec.cells, soup);
  return soup;
}

}  // namespace tactus::experiment
