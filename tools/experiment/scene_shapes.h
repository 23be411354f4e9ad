// The tactus shapes of a scene's bodies, from which the shapes of every engine are made. Thread: [any]; Units: SI.
#pragma once

#include "rt/physics/shapes/shape.h"
#include "tools/experiment/scene.h"

namespace tactus::experiment {

// A capsule lies along its z, a plate is 1 : 0.7 : 0.5; the longest side of each is the edge.
physics::Shape shape_of(const BoxScene& scene, const Cube& body);
// Principal moments [kg m^2] of the homogeneous body, about its own axes.
Vec3d inertia_of(const BoxScene& scene, const Cube& body);
double volume_of(const BoxScene& scene, const Cube& body);  // m^3

}  // namespace tactus::experiment
