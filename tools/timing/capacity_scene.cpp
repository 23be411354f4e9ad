#include "tools/timing/capacity_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tactus::timing {
namespace {

constexpr unsigned kLayers = 8;
constexpr double kCube_m = 0.05, kProxyRadius_m = 0.02;

}  // namespace

std::string capacity_scene(unsigned members, unsigned sub_steps, unsigned ratio, double rate_Hz) {
  // Below 1 kHz coupling and contacts are softer, to be stable at that rate.
  const double slower = std::min(1.0, rate_Hz / 1000);
  // Twice the members, so that a border always exists, and wide enough to be stirred.
  const unsigned cubes = std::max(2 * members, 49 * kLayers);
  const double top_m = kLayers * kCube_m + kProxyRadius_m;
  const double pressed_m = top_m - 0.012, stirred_m = top_m - 0.014;
  std::string text = fmt::format(R"(title = "Worst case: {0} members of a heap of {1} cubes"
effects = ["gravity", "friction"]
[simulation]
ratio = {2}
members = {0}
contact_hertz_Hz = {9}
contact_damping_ratio = 10
sub_steps = {3}
relax_sweeps = 1
global_sub_steps_per_tick = 1
[device]
profile = "virtuose6d"
position_m = [0, 0, {4:.4f}]
[coupling]
stiffness_N_per_m = {10}
damping_Ns_per_m = 5
stiffness_Nm_per_rad = {11}
damping_Nms_per_rad = 0.02
[proxy]
shape = "sphere"
radius_m = {5}
mass_kg = 0.2
friction = 1.0
position_m = [0, 0, {6:.4f}]
[[body]]
shape = "plane"
friction = 0.5
[[generate]]
kind = "pile"
count = {1}
layers = {7}
cube_m = {8}
gap_fraction = 0.04
mass_kg = 0.075
friction = 0.5
wall_height_m = 0.5
wall_thickness_m = 0.05
seed = 1
[hand]
stiffness_N_per_m = 400
damping_Ns_per_m = 12
mass_kg = 0.5
repeat = true
path = [
)",
                                 members, cubes, ratio, sub_steps, top_m, kProxyRadius_m, top_m + 0.001, kLayers,
                                 kCube_m, 250 * slower, 1500 * slower, 4 * slower);
  text += fmt::format("  {{time_s = 0.0, position_m = [0, 0, {:.4f}]}},\n", top_m + 0.001);
  text += fmt::format("  {{time_s = 0.5, position_m = [0, 0, {:.4f}]}},\n", pressed_m);
  for (int i = 1; i <= 8; ++i) {
    const double angle = i * 0.25 * 3.14159265358979;
    text += fmt::format("  {{time_s = {:.1f}, position_m = [{:.4f}, {:.4f}, {:.4f}]}},\n", 0.5 + i,
                        0.05 * std::cos(angle), 0.05 * std::sin(angle), stirred_m);
  }
  text += fmt::format("  {{time_s = 9.0, position_m = [0, 0, {:.4f}]}},\n", top_m + 0.001);
  return text + "]\n";
}

}  // namespace tactus::timing
