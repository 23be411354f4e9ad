// Quality of an engine's simulation while it is timed, measured in the same way for every engine, and its gates: a row
// that fails one is not compared in time.
//
// Sampled between the timed blocks. Units in the names; a share is of the thinner body's thickness. Thread: one.
#pragma once

#include <string>
#include <vector>

#include "tools/experiment/engine.h"
#include "tools/experiment/overlap_judge.h"

namespace tactus::experiment {

struct Quality {
  double overlap_mean_m{0}, overlap_mean_share{0};  // over bodies and samples
  double overlap_max_m{0}, overlap_max_share{0};
  double travel_m{0};        // path length, mean over the bodies, as straight lines between samples
  double rod_travel_m{0};    // the same of the stirrer's rods
  std::uint32_t escaped{0};  // bodies whose centre was in a wall or the floor, or beyond all of them
  bool complete{true};       // every pose was finite, and no pair exceeded the judge's capacity
};

class QualitySampler {
 public:
  explicit QualitySampler(const BoxScene& scene);
  void start(const Engine& engine);  // begins a run and its paths
  void sample(const Engine& engine);
  Quality result() const;  // of all runs; travel: of a run

 private:
  bool is_outside(const Vec3d& centre) const noexcept;

  OverlapJudge judge_;
  std::vector<Wall> walls_;
  physics::Aabb all_walls_;
  std::vector<Posed> last_, last_rods_;
  std::vector<std::uint8_t> escaped_;
  Quality sum_;  // means are sums
  double samples_{0}, runs_{0};
};

// The gates. A body that overlaps by more than half its thickness is pushed out on the far side; the limit is half of
// that.
inline constexpr double kMaxOverlapShare = 0.25, kMaxMeanOverlapShare = 0.02;
// Share of the rods' path in a stirred scene; bodies that are not pushed travel less.
inline constexpr double kMinTravelShare = 0.05;

// The gate that it fails, one line; empty: none.
std::string missed_gate(const Quality& quality);

}  // namespace tactus::experiment
