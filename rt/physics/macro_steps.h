// The number of macro steps in which a long step is taken.
//
// Contacts are found once per macro step, and their points stay fixed to the bodies; within a macro step the gaps
// follow from the motion. Errors grow with the distance that a body moves in a macro step: a ball rolls off its contact
// point, a tip slides past an edge, a fast body is detected too late (max_margin). A haptic tick is short and always
// one macro step. A global step of many ticks takes as many macro steps as its fastest body needs, each with its own
// begin_step and finish_step and the settings of the macro step. The sub-step keeps its length, so warm starts continue
// as within one step. A world at rest, or slow, takes one macro step at no extra cost.
//
// Not for a world with border contacts: those are given for a whole step. A spring's target must be set again for each
// macro step.
//
// Thread: the owner of the World. Units: SI. Bound: linear in bodies and contacts; at most one macro step per
// millisecond and one per sub-step.
#pragma once

#include "rt/physics/world.h"

namespace tactus::physics {

// At least 1, a divisor of the sub-steps. `left_out`, by slot: 1 if the body's motion is not considered, because
// another world computes it.
std::uint32_t macro_steps_of(const World& world, const StepSettings& settings,
                             std::span<const std::uint8_t> left_out = {}) noexcept;

StepSettings settings_of_macro_step(const StepSettings& settings, std::uint32_t macro_steps) noexcept;

}  // namespace tactus::physics
