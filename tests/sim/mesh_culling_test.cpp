#include "rt/physics/collision/mesh_culling.h"

#include <catch2/catch.hpp>

#include "rt/physics/collision/collide_mesh.h"
#include "sim/geometry/hull_builder.h"
#include "tests/sim/geometry/mesh_support.h"
#include "tests/support/random.h"

using namespace tactus;
using namespace tactus::sim;
using namespace tactus::sim::support;
using physics::Shape;
using tactus::test::Random;

namespace {

// A part of a body near rough ground that moves towards it and turns, for a step.
struct Case {
  Shape shape;
  Posed pose;
  Vec3d from_body;
  physics::MotionBound bound;

  physics::PosedPart part() const { return {shape, pose, from_body}; }
  // If the body keeps the shares `go` and `turn` of its velocities.
  Posed after(double go, double turn) const {
    const Quatd turned = quat_from_rotation_vector(turn * bound.turn);
    return {pose.position - from_body + go * bound.advance + rotate(turned, from_body), turned * pose.rotation};
  }
};

Case random_case(const std::vector<physics::Hull>& hulls, Random& random) {
  const Shape shapes[] = {Shape::sphere(0.03), Shape::capsule(0.02, 0.04), Shape::box({0.05, 0.03, 0.02}),
                          Shape::convex(hulls[0], 0)};
  const Vec3d centre{random(-0.2, 0.2), random(-0.2, 0.2), random(0.0, 0.15)};
  const Shape& shape = shapes[random.below(4)];
  Case made{shape, {centre, random.rotation()}, {}, {}};
  if (random.below(2) == 0) made.from_body = random.vector(0.3);
  made.bound.advance = random.vector(0.011);
  made.bound.turn = random.vector(random.below(3) == 0 ? 0.0 : 0.2);
  const double angle = norm(made.bound.turn), radius = norm(made.from_body) + physics::bounding_radius(shape);
  made.bound.rest = angle * radius;
  made.bound.curve = 0.5 * angle * angle * radius;
  return made;
}

}  // namespace

TEST_CASE(
    "A triangle that a body cannot touch in a step has no contact with it, neither now nor where the step takes it") {
  Random random(23);
  const BuiltMesh made = built(height_field(
      10, 0.05, [&](double, double) { return random(-0.02, 0.02); }, [&] { return random.below(2) == 0; }));
  std::vector<Vec3d> points;
  for (int k = 0; k < 20; ++k) points.push_back(0.05 * random.direction());
  const std::vector<physics::Hull> hulls{build_hull(points).value().hull};
  physics::StepSettings settings;
  settings.max_margin = 1;  // beyond any motion of these cases
  int kept = 0, dropped = 0;
  for (int n = 0; n < 3000; ++n) {
    const Case made_case = random_case(hulls, random);
    const Posed& now = made_case.pose;
    const physics::MeshCulling culling(made.mesh, made_case.part(), made_case.bound, {}, settings, hulls);
    const auto share = [&random] { return random.below(2) == 0 ? 1.0 : random(0, 1); };
    const double go = share(), turn = share();
    const Posed then = made_case.after(go, turn);
    for (std::uint32_t t = 0; t < made.mesh.triangles.size(); ++t) {
      if (culling.can_touch(t)) {
        ++kept;
        continue;
      }
      ++dropped;
      const std::uint32_t alone[] = {t};
      INFO("case " << n << ", triangle " << t << ", shape " << int(made_case.shape.kind));
      const auto touches = [&](const Posed& pose) {
        const auto m = physics::collide_patch({made_case.shape, pose}, {made.mesh, {}, alone}, {.margin = 0.0}, hulls);
        return m.count > 0;
      };
      const auto& patch = made.mesh.patches[made.mesh.triangles[t].patch];
      REQUIRE_FALSE(touches(now));
      if (dot(patch.normal, now.position) > patch.offset) REQUIRE_FALSE(touches(then));
    }
  }
  REQUIRE((kept > 1000 && dropped > 1000));
}
