// The effects that a scene can declare: their names, their conditions of use, and the set-up of the worlds with them.
//
// One table (scene_effects.cpp) has a row for each; the loader, the report and the worlds use it. An effect that is
// declared but not used is left out of the worlds, as if it were not declared.
// Thread: [setup].
#pragma once

#include <span>
#include <string_view>

#include "rt/physics/step.h"
#include "sim/model/scene.h"

namespace tactus::sim {

struct EffectInfo {
  std::string_view name;  // in the scene's list
  bool DeclaredEffects::*declared;
  bool (*used)(const Scene& scene);  // true if it would act on something in the scene
  std::string_view unused;           // reason why it would not
  std::string_view cost;             // added computation in a tick
  bool hand_only{false};             // acts on the hand alone: the global world does not have it
};

std::span<const EffectInfo> known_effects() noexcept;
const EffectInfo* find_effect(std::string_view name) noexcept;            // null: unknown
const EffectInfo* find_effect(bool DeclaredEffects::*declared) noexcept;  // never null
std::string effect_words();                                               // all names, for messages
// True if the effect is declared and used.
bool is_in_use(const Scene& scene, const EffectInfo& effect);

// Effect set-ups of the haptic side's world, and of the global one, which has no effects that only act on the hand. The
// scene must outlive the world.
physics::EffectSetups effect_setups(const Scene& scene);
physics::EffectSetups global_effect_setups(const Scene& scene);
// Sets the effects that are part of the step itself: gravity, friction, the gyroscopic term.
void choose_effects(const Scene& scene, physics::StepSettings& settings);

}  // namespace tactus::sim
