// Marks the contact points of compounds that their other parts make redundant. The solver leaves these points out.
//
// A face where two parts of a compound meet is inside the body and not part of its surface. Another body that slightly
// overlaps the body at such a seam would be pushed along the surface, by the part that it overlaps least. A contact is
// redundant if at all its points another part of the compound is just beyond the touched face.
// Two compounds that touch on one face have a contact, with points of its own, for each pair of parts there; most of
// the points are on seams. On a plane the gap is a linear function of the position. So a point inside a triangle of
// three others, with a gap no less than the linear interpolation of theirs, cannot overlap unless one of them does: it
// is redundant. With all points, many rows would share a load, the sweeps would end before they have distributed it,
// and restitution would divide an impact among the rows.
// Gaps, heights and positions are compared with the slop as tolerance, since no row corrects an overlap of that size.
// The impulse of a point that has become redundant is added to that of the nearest remaining point. Frame: world.
// Units: SI. Thread: [rt]; pure. Bound: points times the parts of a body, points times kMaxContactPlanes (contacts of
// two bodies with further normals keep all their points), and points times those whose impulse is transferred.
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

// `contacts`: of one step, sorted by key, no point redundant. `slop` [m].
void mark_redundant_points(const TouchingBodies& bodies, double slop, std::span<Contact> contacts) noexcept;

}  // namespace tactus::physics
