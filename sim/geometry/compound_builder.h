// Builds a compound from its parts: moves the origin to the centre of mass, turns the axes to the principal axes, and
// computes bounds and exact mass properties. Thread: [setup]. Units: m, kg, kg m^2.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "rt/physics/shapes/compound.h"
#include "rt/physics/shapes/hull.h"

namespace tactus::sim {

struct GivenPart {
  physics::Shape shape;   // any convex shape
  Posed given_from_part;  // of the shape's own frame (its centre of mass, principal axes)
  double mass_kg{0};
  Vec3d inertia_kg_m2;  // of the part alone, about its own centre along its own axes
};

// The mass properties of the whole in place of the parts' sums.
struct GivenMass {
  Vec3d centre_m;          // in the frame of the given poses
  SymMat3d inertia_kg_m2;  // about that centre, along the axes of that frame
};

struct BuiltCompound {
  physics::Compound compound;  // refers to `parts`
  std::shared_ptr<const std::vector<physics::CompoundPart>> parts;
  Posed given_from_body;
  double mass_kg{0};    // sum of the parts' masses
  Vec3d inertia_kg_m2;  // principal moments of the whole with that mass
};

// `parts`: 1 to kMaxParts, with positive masses. `hulls`: the list to which hull parts refer. Regions where parts
// overlap count once for each part, as in MJCF and URDF.
BuiltCompound build_compound(const std::vector<GivenPart>& parts, physics::Hulls hulls,
                             const std::optional<GivenMass>& given = {});

}  // namespace tactus::sim
