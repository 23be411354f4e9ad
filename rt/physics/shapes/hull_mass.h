// Changes a hull's frame and inertia to those of a body that is not homogeneous.
//
// The hull's frame moves to `centre`, in the frame of the vertices given to make_hull, and to the principal axes of
// `inertia_per_kg`, about `centre` along the axes of that frame. The surface stays where it is.
// Units: m, m^2. Thread: [setup]. Bound: that of make_hull. Errors: kFlat where the centre is not inside the hull;
// `hull` and `given_from_body` are then not usable.
#pragma once

#include "rt/physics/shapes/hull.h"

namespace tactus::physics {

[[nodiscard]] HullFault set_mass_properties(const Vec3d& centre, const SymMat3d& inertia_per_kg, Hull& hull,
                                            Posed& given_from_body) noexcept;

}  // namespace tactus::physics
