// Common interface of the physics engines in the experiments: load a scene, step it, read figures.
//
// Each engine's own file translates the scene, and only it includes the engine's headers. For an engine that was not
// available when tactus was built, the maker returns null.
// Thread: one; a step runs only on the caller's thread, unless helpers are given. Units: SI.
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

// Figures after the last step, as the engine reports them.
struct Measurement {
  double contacts{0};                // contact points reported by the engine
  double touching_pairs{0};          // pairs of bodies with a point of separation 0 or less
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
  virtual std::string settings() const = 0;          // its settings, one line
  // Why its figures are invalid (work was left out); empty: valid.
  virtual std::string failure() const { return {}; }
  // Time of the broad phase in the last step [us]; 0 if not requested.
  virtual double broad_phase_us() const { return 0; }
};

struct EngineOptions {
  bool tuned{false};
  unsigned iterations{0};  // peers only: of the contact solver per step; 0: the engine's default, ODE tuned 10
  // tactus only; empty: as in a run, single precision for a global world.
  std::optional<physics::SweepPrecision> precision{};
  bool time_broad_phase{false};  // tactus only
  std::vector<int> helpers{};    // tactus only: cores of the threads that share its steps, in addition to the caller's
  unsigned sub_steps{0};         // tactus only; 0: 4 in a step of 1 ms, 10 in one of 10 ms
};

std::unique_ptr<Engine> make_tactus(const BoxScene& scene, const EngineOptions& options);
std::unique_ptr<Engine> make_bullet(const BoxScene& scene, const EngineOptions& options);  // null: not built in
std::unique_ptr<Engine> make_ode(const BoxScene& scene, const EngineOptions& options);     // null: not built in
std::unique_ptr<Engine> make_mujoco(const BoxScene& scene, const EngineOptions& options);  // null: not built in
bool mujoco_takes(const BoxScene& scene);
inline bool takes_every_scene(const BoxScene&) { return true; }

struct EngineKind {
  std::string_view name;     // in the tables: "bullet-tuned"
  std::string_view package;  // required Debian package; empty: none
  bool tuned;
  std::unique_ptr<Engine> (*make)(const BoxScene&, const EngineOptions&);
  bool available;          // was available when this program was built
  unsigned iterations{0};  // see EngineOptions
  bool (*takes)(const BoxScene&){takes_every_scene};
};

// All engines, tactus first.
const std::vector<EngineKind>& engine_kinds();

// Same, plus the tuned ones with fewer and with more iterations: "bullet-tuned-4".
const std::vector<EngineKind>& compared_kinds();

// Root mean square of the speeds.
double residual_speed(const std::vector<CubeState>& cubes);

}  // namespace tactus::experiment
