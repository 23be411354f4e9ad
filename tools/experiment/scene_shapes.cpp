#include "tools/experiment/scene_shapes.h"

namespace tactus::experiment {

using physics::Shape;

Shape shape_of(const BoxScene& scene, const Cube& body) {
  const double half = 0.5 * body.edge_m;
  switch (body.form) {
    case Form::kSphere:
      return Shape::sphere(half);
    case Form::kCapsule:
      return Shape::capsule(0.6 * half, 0.4 * half);
    case Form::kPlate:
      return Shape::box({half, 0.7 * half, 0.5 * half});
    case Form::kHull:
      return Shape::convex(scene.hulls[body.hull], body.hull);
    case Form::kCube:
      break;
  }
  return Shape::box({half, half, half});
}

Vec3d inertia_of(const BoxScene& scene, const Cube& body) {
  if (body.form == Form::kHull) return body.mass_kg * scene.hulls[body.hull].inertia_per_kg;
  return physics::inertia_of(shape_of(scene, body), body.mass_kg);
}

double volume_of(const BoxScene& scene, const Cube& body) {
  if (body.form == Form::kHull) return scene.hulls[body.hull].volume;
  return physics::volume_of(shape_of(scene, body));
}

}  // namespace tactus::experiment
