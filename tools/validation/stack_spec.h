// A stack of cubes, from the ground up, as every engine can be given it, and whether it stands. Thread: [any].
#pragma once

#include <span>
#include <string>
#include <vector>

#include "rt/base/spatial.h"

namespace tactus::hard_cases {

struct StackSpec {
  std::string name;
  std::vector<double> masses_kg;  // from the ground up
  double edge_m{0.1}, friction{0.5};
  double seconds{20};

  Vec3d start_of(std::size_t k) const { return {0, 0, edge_m * (0.5 + static_cast<double>(k))}; }
};

StackSpec equal_stack(unsigned count);
StackSpec heavy_on(double top_kg, unsigned count, double each_kg);

// The stacks that other engines are compared on.
std::vector<StackSpec> compared_stacks();

// Most that a cube went to the side, and that the top one sank.
struct StackState {
  double side_m{0}, sag_m{0};
  bool stands{false};  // none went to the side by half its edge or lost its place in the height
};
StackState judge(const StackSpec& spec, std::span<const Vec3d> centres);

// The same by tactus, with contacts as stiff as in the hard cases, at the balanced accuracy.
StackState stack_in_tactus(const StackSpec& spec, double step_s);

}  // namespace tactus::hard_cases
