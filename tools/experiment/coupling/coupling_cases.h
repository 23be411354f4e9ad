// The seven scenes on which couplings are compared, each with a hand that comes, presses, holds still, then moves on.
//
// In six of them the bodies that hang together with the proxy are at least twice the cap on members, so that the border
// is at work; the peg in its shaft has none, and shows what the rest costs. Thread: [setup]. Units: SI. Frame: world.
#pragma once

#include <span>
#include <string>

#include "rt/base/result.h"
#include "sim/model/scene.h"

namespace tactus::experiment {

struct CouplingCase {
  std::string name, file;  // of sim/scenes; or any path, with `own_hand`
  unsigned members{64};    // cap of the sub-world
  Vec3d press_m;           // the hand's target, from the proxy's start, while it holds
  Vec3d slide_m;           // and from there while it moves
  bool own_hand{false};    // the scene's own script instead
};

std::span<const CouplingCase> coupling_cases();

// Times of the hand's script [s].
struct HandTimes {
  static constexpr double kPressed = 0.5, kHeld = 1.7, kEnd = 2.6;
};

// Any scene file, with its own hand and cap. One line where it cannot be loaded.
Result<CouplingCase> case_of_file(const std::string& path);
// The scene of a case as its file has it, with its own hand.
Result<sim::Scene> load_case_scene(const CouplingCase& one);
// The scene with the hand's script in place; every seed but 0 makes the hand press and slide a little elsewhere.
Result<sim::Scene> load_coupling_case(const CouplingCase& one, std::uint64_t seed);

}  // namespace tactus::experiment
