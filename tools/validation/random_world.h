// Worlds that nobody would build, by seed: mass ratios to 1e6, sizes from 1 mm to 10 m, frictions 0 to 5, slivers, deep
// overlaps and coincident bodies at the start, and a device that pulls on one of them at its limits.
//
// The same seed gives the same world on every machine. What must hold: the gates of CaseWorld, the same state twice,
// and mechanical energy within what was given: work, and overlaps pushed out at the push speed.
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
  Vec3d device_speed_m_per_s;  // turns round every ten ticks
};

RandomWorld make_random_world(std::uint64_t seed);

struct RandomRun {
  std::string broken_gate;  // the first; or nothing
  std::uint64_t hash{0};
};
RandomRun run_twice(const RandomWorld& world);

// The same failure with as few bodies and ticks as it takes: bodies are left out one by one while `fails`.
RandomWorld shrink(RandomWorld world, const std::function<bool(const RandomWorld&)>& fails);

// What it has become after `seconds` with nothing held, in steps of 1 ms.
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
  std::vector<Waypoint> path{{0, {0, 0, kOutOfTheWay_m}}};  // the proxy begins at its start
};

// A scene file of it, for `tactus run` and for looking at. `about`: lines of a comment.
std::string to_scene(const RandomWorld& world, const std::string& about, const ScriptedHand& hand, unsigned members);
// With a hand that is out of the way.
std::string to_scene(const RandomWorld& world, const std::string& broken_gate);

}  // namespace tactus::hard_cases
