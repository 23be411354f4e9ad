// A stack of cubes in a form that every engine can load, and the test whether it stands. Thread: [any].
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

// The stacks on which engines are compared.
std::vector<StackSpec> compared_stacks();

// Largest lateral displacement of a cube, and the sinking of the top cube.
struct StackState {
  double side_m{0}, sag_m{0};
  bool stands{false};  // no cube moved sideways by half its edge or changed its place in the order of heights
};
StackState judge(const StackSpec& spec, std::span<const Vec3d> centres);

// Simulates the stack with tactus, with the contact stiffness of the hard cases, at balanced accuracy.
StackState stack_in_tactus(const StackSpec& spec, double step_s);

}  // namespace tactus::hard_cases
