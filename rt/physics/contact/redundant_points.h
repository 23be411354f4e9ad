// Marks the contact points of compounds that their other parts make redundant. The solver leaves these points out.
//
// A face inside a compound, where two parts meet, is no surface of the body. What overlaps the seam by a hair is pushed
// along it by the part that it overlaps least. A contact is redundant if at all its points the body goes on beyond the
// face, in another part.
// Two bodies of several parts touch on one face by several pairs of parts: every pair gives points of its own, most of
// them on seams between others. On a plane the gap is a linear function, so a point between three others that is no
// deeper than this function closes when they close. With all of them many rows share a load, the sweeps do not finish
// to distribute it, and restitution divides an impact among them.
// Gaps, heights and places are compared with the slop, which no row corrects. The impulse of a point that has become
// redundant goes to the nearest point that is left. Frame: world. Units: SI. Thread: [rt]; pure. Bound: points times
// the parts of a body, points times kMaxContactPlanes (contacts of two bodies with further normals stay whole), and
// points times those whose impulse is handed on.
#pragma once

#include <span>

#include "rt/physics/body.h"
#include "rt/physics/contact/contact.h"
#include "rt/physics/shapes/shape_lists.h"

namespace tactus::physics {

inline constexpr std::uint32_t kMaxContactPlanes = 6;

// By slot.
struct TouchingBodies {
  std::span<const Body> moving, fixed;
  const ShapeLists& shapes;
};

// `contacts`: of one step, sorted by key. Sets `redundant` of all their points. `slop` [m].
void mark_redundant_points(const TouchingBodies& bodies, double slop, std::span<Contact> contacts) noexcept;

}  // namespace tactus::physics
