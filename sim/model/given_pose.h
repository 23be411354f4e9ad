// The one rule for poses that leave the program as the scene file gives them: `position_m` and the rotation of a body's
// table place the frame in which its points, parts or triangles are given.
//
// Inside, a body's frame has its origin at the centre of mass and its axes along the principal axes of inertia, so for
// hulls, meshes and compounds the two differ by ListedBody::given_from_body, constant in time. For other shapes, and
// for bodies of generators, they are the same, bit by bit. Frame: world. Thread: any. Bound: constant. Errors: none.
#pragma once

#include "sim/model/scene.h"

namespace tactus::sim {

// Pose of a body's own frame in the given one.
inline Posed given_from_body(const Scene& scene, BodyId body) {
  return body < scene.listed.size() ? scene.listed[body].given_from_body : Posed{};
}

// Pose of the given frame of a body whose own frame has the pose `world_from_body`.
inline Posed given_pose(const Scene& scene, BodyId body, const Posed& world_from_body) {
  const Posed given = given_from_body(scene, body);
  return given == Posed{} ? world_from_body : world_from_body * inverse(given);
}

}  // namespace tactus::sim
