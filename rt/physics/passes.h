// In how many passes a long step is taken.
//
// Contacts are found once in a pass and their points stay with the bodies; between, gaps follow from the motion. A
// body that goes far in a pass leaves its points behind: a ball rolls off its own, a tip slides past an edge, what is
// fast is not seen coming (max_margin). A haptic tick is short enough and always one pass; a global step of many ticks
// is taken in as many passes as its fastest body needs, each with its own begin_step and finish_step of the pass's
// settings. Sub-steps stay as long as they are, so warm starts go on as within one step, and a world at rest, or slow,
// has one pass and pays nothing. Not for a world with border contacts: those are given for a whole step. A spring's
// target is given anew for each pass.
// Thread: the owner of the World. Units: SI. Bound: linear in bodies and contacts; as many passes as milliseconds or
// sub-steps.
#pragma once

#include "rt/physics/world.h"

namespace tactus::physics {

// Half of the thinnest side; of a sphere or a capsule the radius [m].
double half_thickness(const Shape& shape) noexcept;

// At least 1, a divisor of the sub-steps. `left_out`, by slot: 1 where another world knows better how the body moves.
std::uint32_t passes_of(const World& world, const StepSettings& settings,
                        std::span<const std::uint8_t> left_out = {}) noexcept;

StepSettings settings_of_pass(const StepSettings& settings, std::uint32_t passes) noexcept;

}  // namespace tactus::physics
