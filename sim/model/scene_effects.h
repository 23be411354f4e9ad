// The effects that a scene can call for: their words, what uses them, and what the worlds are told of them.
//
// One table (scene_effects.cpp) has a line for each; the loader, the report and the worlds go by it. An effect that is
// declared and not used is left out of the worlds as if it were not declared. Thread: [setup].
#pragma once

#include <span>
#include <string_view>

#include "rt/physics/step.h"
#include "sim/model/scene.h"

namespace tactus::sim {

struct EffectInfo {
  std::string_view name;  // the word in the scene's list
  bool Effects::*declared;
  bool (*used)(const Scene& scene);  // is there anything to do, were it declared?
  std::string_view unused;           // why not
  std::string_view cost;             // what it adds to a tick
};

std::span<const EffectInfo> known_effects() noexcept;
const EffectInfo* find_effect(std::string_view name) noexcept;
std::string effect_words();  // all of them, for messages
// Declared, and there is something to do.
bool is_in_use(const Scene& scene, const EffectInfo& effect);

// What a world of the scene is made with, the haptic side's and the global one, which has nothing that the hand alone
// feels. The scene must outlive it.
physics::EffectSetups effect_setups(const Scene& scene);
physics::EffectSetups global_effect_setups(const Scene& scene);
// Effects that are the step's own: gravity, friction, the gyroscopic term.
void choose_effects(const Scene& scene, physics::StepSettings& settings);

}  // namespace tactus::sim
