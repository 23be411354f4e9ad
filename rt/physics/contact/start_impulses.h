// The impulses with which a new manifold starts: those of the same pair in the last step, or in another world.
//
// Frame: world. Units: N s, of one sub-step. Thread: [any]; pure. Bound: kMaxManifoldPoints^2 comparisons.
#pragma once

#include <array>

#include "rt/physics/contact/contact.h"
#include "rt/physics/contact/warm_start.h"

namespace tactus::physics {

struct StartImpulse {
  double normal{}, tangent[2]{};  // along the manifold's normal and `tangents_of(normal)`
};
using StartImpulses = std::array<StartImpulse, kMaxManifoldPoints>;  // by point of the manifold

// The impulses of the same features of `last`, times `impulse_scale`: this sub-step / that of the last step. If a point
// of the last step is not chosen again, the nearest point takes its impulse, so that a stack does not drop when the
// choice of its corners changes.
StartImpulses start_impulses(const Manifold& manifold, const Contact& last, double impulse_scale) noexcept;

// The impulses of the same features of another world's contact, in a sub-step of `sub_step` [s].
StartImpulses start_impulses(const Manifold& manifold, const WarmStart& given, double sub_step) noexcept;

// Gives a contact the impulses of another world's contact of the same pair, by feature. Points that the other one does
// not have keep theirs.
void set_impulses(const WarmStart& given, double sub_step, Contact& contact) noexcept;

}  // namespace tactus::physics
