// A physics engine as the experiments see it: a scene goes in, steps are made, figures come out.
//
// Each engine's own file translates the scene; nothing else knows its headers. An engine that was not there when
// tactus was built has a maker that gives none.
// Thread: one; a step runs on the caller's thread alone, unless it is given helpers. Units: SI.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rt/physics/sweep_precision.h"
#include "tools/experiment/scene.h"

namespace tactus::experiment {

// What holds after the last step, by the engine's own books.
struct Measurement {
  double contacts{0};                // contact points that the engine itself counts
  double touching_pairs{0};          // pairs of bodies with a point that does not gape
  double residual_speed_m_per_s{0};  // root mean square over the cubes
};

struct CubeState {
  Vec3d position, velocity;
  Quatd rotation;  // world_from_cube
};

class Engine {
 public:
  virtual ~Engine() = default;
  virtual void step() = 0;  // what is timed
  virtual Measurement measure() = 0;
  virtual std::vector<CubeState> cubes() const = 0;  // in the scene's order
  virtual std::vector<Posed> rods() const = 0;       // of the stirrer, in its order
  virtual std::string settings() const = 0;          // what it runs with, in a line
  // Why its figures do not count (work was left out); empty while they do.
  virtual std::string failure() const { return {}; }
  // Of the last step, the time in which pairs were found [us]; 0 where it was not asked for.
  virtual double broad_phase_us() const { return 0; }
};

struct EngineOptions {
  bool tuned{false};
  unsigned iterations{0};  // peers only: of the contact solver in a step; 0: as it comes, ODE tuned 10
  // tactus only; none: as in a run, single precision where the world is a global one.
  std::optional<physics::SweepPrecision> precision{};
  bool time_broad_phase{false};  // tactus only
  std::vector<int> helpers{};    // tactus only: cores of the threads that share its steps, beside the caller
  unsigned sub_steps{0};         // tactus only; 0: 4 in a step of 1 ms, 10 in one of 10 ms
};

std::unique_ptr<Engine> make_tactus(const BoxScene& scene, const EngineOptions& options);
std::unique_ptr<Engine> make_bullet(const BoxScene& scene, const EngineOptions& options);  // none: not built in
std::unique_ptr<Engine> make_ode(const BoxScene& scene, const EngineOptions& options);     // none: not built in

struct EngineKind {
  std::string_view name;     // in the tables: "bullet-tuned"
  std::string_view package;  // Debian package that it needs; empty: none
  bool tuned;
  std::unique_ptr<Engine> (*make)(const BoxScene&, const EngineOptions&);
  bool available;          // was there when this program was built
  unsigned iterations{0};  // see EngineOptions
};

// All that exist, tactus first.
const std::vector<EngineKind>& engine_kinds();

// The same, and the tuned ones with fewer and with more iterations: "bullet-tuned-4".
const std::vector<EngineKind>& compared_kinds();

// Root mean square of the speeds.
double residual_speed(const std::vector<CubeState>& cubes);

}  // namespace tactus::experiment
