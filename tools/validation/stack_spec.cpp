#include "tools/validation/stack_spec.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tactus::hard_cases {

StackSpec equal_stack(unsigned count) {
  return {.name = fmt::format("{} cubes of 1 kg", count),
          .masses_kg = std::vector<double>(count, 1.0),
          .edge_m = 0.1,
          .friction = 0.5,
          .seconds = 20};
}

StackSpec heavy_on(double top_kg, unsigned count, double each_kg) {
  StackSpec spec{.name = fmt::format("{:g} kg on {} cubes of {:g} kg", top_kg, count, each_kg),
                 .masses_kg = std::vector<double>(count, each_kg),
                 .edge_m = 0.1,
                 .friction = 0.5,
                 .seconds = 10};
  spec.masses_kg.push_back(top_kg);
  return spec;
}

std::vector<StackSpec> compared_stacks() { return {equal_stack(20), heavy_on(100, 5, 1), heavy_on(1000, 5, 1)}; }

StackState judge(const StackSpec& spec, std::span<const Vec3d> centres) {
  StackState state;
  state.stands = centres.size() == spec.masses_kg.size();
  double below = -0.5 * spec.edge_m;
  for (std::size_t k = 0; k < centres.size(); ++k) {
    state.side_m = std::max(state.side_m, std::hypot(centres[k].x, centres[k].y));
    state.stands = state.stands && centres[k].z - below > 0.5 * spec.edge_m;
    below = centres[k].z;
  }
  if (!centres.empty()) state.sag_m = spec.start_of(centres.size() - 1).z - centres.back().z;
  state.stands = state.stands && state.side_m < 0.5 * spec.edge_m;
  return state;
}

}  // namespace tactus::hard_cases
