// The number of passes in which a long step is taken.
//
// Contacts are found once per pass, and their points stay fixed to the bodies; within a pass the gaps follow from the
// motion. Errors grow with the distance that a body moves in a pass: a ball rolls off its contact point, a tip slides
// past an edge, a fast body is detected too late (max_margin). A haptic tick is short and always one pass. A global
// step of many ticks takes as many passes as its fastest body needs, each with its own begin_step and finish_step and
// the settings of the pass. The sub-step keeps its length, so warm starts continue as within one step. A world at rest,
// or slow, takes one pass at no extra cost.
// Not for a world with border contacts: those are given for a whole step. A spring's target must be set again for each
// pass.
// Thread: the owner of the World. Units: SI. Bound: linear in bodies and contacts; at most one pass per millisecond and
// one per sub-step.
#pragma once

#include "rt/physics/world.h"

namespace tactus::physics {

// Half of the thinnest side; the radius of a sphere or a capsule [m].
double half_thickness(const Shape& shape) noexcept;

// At least 1, a divisor of the sub-steps. `left_out`, by slot: 1 if the body's motion is not considered, because
// another world computes it.
std::uint32_t passes_of(const World& world, const StepSettings& settings,
                        std::span<const std::uint8_t> left_out = {}) noexcept;

StepSettings settings_of_pass(const StepSettings& settings, std::uint32_t passes) noexcept;

}  // namespace tactus::physics
