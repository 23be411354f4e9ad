// Extreme random worlds, by seed: mass ratios to 1e6, sizes from 1 mm to 10 m, frictions 0 to 5, slivers, deep
// overlaps and coincident bodies at the start, and a device that pulls on one of them at its limits.
//
// The same seed gives the same world on every machine. Required: the gates of CaseWorld, the same state in two runs,
// and a mechanical energy of at most the initial energy plus the work done plus the energy of overlaps resolved at the
// push speed.
// Thread: one. Units: SI.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "rt/physics/body.h"
#include "tools/validation/hard_case.h"

namespace tactus::hard_cases {

struct RandomWorld {
  std::uint64_t seed{0};
  std::vector<physics::Body> bodies;  // the first is the proxy
  double contact_hertz{1000};
  unsigned ticks{60};
  bool held{false};  // the proxy by the device
  double stiffness_N_per_m{0}, damping_Ns_per_m{0};
  Vec3d device_speed_m_per_s;  // reversed every ten ticks
};

RandomWorld make_random_world(std::uint64_t seed);

struct RandomRun {
  std::string broken_gate;  // the first gate that failed; empty: none
  std::uint64_t hash{0};
};
RandomRun run_twice(const RandomWorld& world);

// Reduces a failing world: removes bodies one by one, and ticks, as long as `fails` returns true.
RandomWorld shrink(RandomWorld world, const std::function<bool(const RandomWorld&)>& fails);

// Returns the world after `seconds` without the device, in steps of 1 ms.
RandomWorld settled(RandomWorld world, double seconds);

// A proxy and the hand that moves it. Units: SI; frame: world.
struct ScriptedHand {
  struct Waypoint {
    double time_s{0};
    Vec3d at_m;
  };
  static constexpr double kOutOfTheWay_m = 1000;

  double radius_m{1e-3}, mass_kg{0.2}, friction{0.5};       // of the proxy, a sphere
  double stiffness_N_per_m{2000}, damping_Ns_per_m{5};      // of the coupling
  std::vector<Waypoint> path{{0, {0, 0, kOutOfTheWay_m}}};  // the proxy starts at its first point
};

// Writes the world as a scene file for `tactus run`. `about`: lines of a comment.
std::string to_scene(const RandomWorld& world, const std::string& about, const ScriptedHand& hand, unsigned members);
// Same, with the hand out of reach.
std::string to_scene(const RandomWorld& world, const std::string& broken_gate);

// A random world that breaks a gate, shrunk, as a scene file.
struct BrokenWorld {
  std::uint64_t seed{0};
  std::string gate, scene;
};
// Runs the worlds of some seeds, in order.
std::vector<BrokenWorld> broken_worlds(std::uint64_t first, std::uint64_t worlds);

template <class Io>
void fields(Io& io, BrokenWorld& world) {  // for experiment/part_bytes.h
  auto& [seed, gate, scene] = world;
  io(seed, gate, scene);
}

}  // namespace tactus::hard_cases
