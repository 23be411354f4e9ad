// The seven scenes on which couplings are compared, each with a hand that approaches, presses, holds still, then moves
// sideways.
//
// In six of them the number of bodies connected to the proxy by contacts is at least twice the cap of members, so that
// a border exists. The peg in its shaft has no border and shows the errors of the remaining parts. Thread: [setup].
// Units: SI. Frame: world.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "rt/base/result.h"
#include "sim/model/scene.h"

namespace tactus::experiment {

struct CouplingCase {
  std::string name, file;  // of sim/scenes; or any path, with `own_hand`
  unsigned members{64};    // cap of the sub-world
  Vec3d press_m;           // the hand's target, from the proxy's start, while it holds
  Vec3d slide_m;           // displacement from there while it moves
  bool own_hand{false};    // true: the scene's own script instead
};

std::span<const CouplingCase> coupling_cases();
std::vector<std::string> coupling_case_names();

// Times of the hand's script [s].
struct HandTimes {
  static constexpr double kPressed = 0.5, kHeld = 1.7, kEnd = 2.6;
};

// Makes a case of any scene file, with its own hand and cap. Error, one line: it cannot be loaded.
Result<CouplingCase> case_of_file(const std::string& path);
// The scene of a case as in its file, with its own hand.
Result<sim::Scene> load_case_scene(const CouplingCase& one);
// The paths of the cases' scenes.
std::vector<std::string> files_of(std::span<const CouplingCase> cases);
// The scene with the case's hand script; every seed except 0 slightly changes where the hand presses and slides.
Result<sim::Scene> load_coupling_case(const CouplingCase& one, std::uint64_t seed);

}  // namespace tactus::experiment
