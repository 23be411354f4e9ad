// Cylinders and cones: their contacts are those of the round body, whatever way it has turned.
#include "rt/physics/collision/collide_cylinder.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "rt/physics/contact/rolling_side.h"
#include "rt/physics/world.h"
#include "tests/support/physics_bench.h"

using namespace tactus;
using namespace tactus::physics;
using tactus::test::kGravity;
using tactus::test::kPi;
using tactus::test::PhysicsBench;
using tactus::test::Random;

namespace {

Quatd turn(const Vec3d& axis, double angle) { return quat_from_rotation_vector(axis * (angle / norm(axis))); }

// z to y, so that an axis along z lies.
const Quatd kLying = turn({1, 0, 0}, 0.5 * kPi);

Manifold touch(const Shape& a, const Posed& pose_a, const Shape& b, const Posed& pose_b, double margin) {
  AxisCache cache;
  return collide({a, pose_a}, {b, pose_b}, {.margin = margin}, cache);
}

double least_separation(const Manifold& m) {
  double least = m.points[0].separation;
  for (std::uint32_t i = 1; i < m.count; ++i) least = std::min(least, m.points[i].separation);
  return least;
}

// The nearest point of a solid cylinder or cone, in its frame.
Vec3d nearest_in(const Shape& shape, const Vec3d& p) {
  const double low = RoundHull::lower_end(shape), high = low + 2 * shape.half_length;
  const double across = std::hypot(p.x, p.y);
  const Vec3d out = across > 0 ? Vec3d{p.x / across, p.y / across, 0} : Vec3d{1, 0, 0};
  if (shape.kind == ShapeKind::kCylinder)
    return out * std::min(across, shape.radius) + Vec3d{0, 0, std::clamp(p.z, low, high)};
  // In the half plane (across, z): a triangle (0, low), (r, low), (0, high).
  const double r = shape.radius, h = high - low;
  if (across >= 0 && p.z >= low && across <= r * (high - p.z) / h) return p;
  const double t = std::clamp(((across - r) * -r + (p.z - low) * h) / (r * r + h * h), 0.0, 1.0);
  const Vec3d on_side = out * (r * (1 - t)) + Vec3d{0, 0, low + t * h};
  const Vec3d on_base = out * std::min(across, r) + Vec3d{0, 0, low};
  return norm(p - on_side) <= norm(p - on_base) ? on_side : on_base;
}

Vec3d nearest_of(const Shape& shape, const Posed& pose, const Vec3d& p) {
  const Vec3d own = rotate_inverse(pose.rotation, p - pose.position);
  if (shape.kind == ShapeKind::kCylinder || shape.kind == ShapeKind::kCone) return pose * nearest_in(shape, own);
  Vec3d near;  // a box
  for (int i = 0; i < 3; ++i) near[i] = std::clamp(own[i], -shape.half_extents[i], shape.half_extents[i]);
  return pose * near;
}

// Distance of two convex solids that are apart, by projecting from one to the other in turns.
double distance(const Shape& a, const Posed& pose_a, const Shape& b, const Posed& pose_b) {
  Vec3d on_a = pose_a.position, on_b;
  double before = 1e9;
  for (int i = 0; i < 20000; ++i) {
    on_b = nearest_of(b, pose_b, on_a);
    on_a = nearest_of(a, pose_a, on_b);
    const double now = norm(on_a - on_b);
    if (before - now < 1e-13) break;
    before = now;
  }
  return norm(on_a - on_b);
}

}  // namespace

TEST_CASE("The topologies are closed and the planes hold all corners, at any alignment") {
  for (const Shape& shape : {Shape::cylinder(0.05, 0.08), Shape::cylinder(0.2, 0.01), Shape::cone(0.05, 0.06)})
    for (const double angle : {0.0, 0.7, 2.9}) {
      const RoundHull hull(shape, {std::cos(angle), std::sin(angle)});
      const HullView view = hull.view();
      const HullTopology& t = *view.topology;
      CHECK(t.vertices + t.faces == t.edges + 2);
      for (std::uint32_t f = 0; f < view.padded_faces; ++f) {
        CHECK(norm(view.normal(f)) == Approx(1).epsilon(1e-12));
        double highest = -1;
        for (std::uint32_t v = 0; v < view.padded; ++v) highest = std::max(highest, view.height(f, view.vertex(v)));
        CHECK(highest == Approx(0).margin(1e-12));
      }
      for (std::uint32_t f = 0; f < t.faces; ++f) {  // loops run counter-clockwise seen from outside
        const auto loop = t.loop(f);
        const Vec3d a = view.vertex(loop[0]), b = view.vertex(loop[1]), c = view.vertex(loop[2]);
        CHECK(dot(cross(b - a, c - a), view.normal(f)) > 0);
      }
      for (std::uint32_t e = 0; e < t.edges; ++e) {
        const double cosine = dot(view.normal(t.edge[e].left), view.normal(t.edge[e].right));
        CHECK(view.edge_secant[e] >= 1 / std::sqrt(0.5 * (1 + cosine)) - 1e-12);
        CHECK(view.edge_secant[e] <= view.largest_secant);
      }
    }
}

TEST_CASE("Mass, inertia and bounds of cylinders and cones agree with sums over many small pieces") {
  Random random(2);
  for (const Shape& shape : {Shape::cylinder(0.05, 0.08), Shape::cone(0.06, 0.05)}) {
    const Quatd q = random.rotation();
    const Aabb box = bounds_of(shape, {{1, 2, 3}, q}, 0.001);
    Vec3d first, second;
    double inside = 0;
    const int n = 160;
    Aabb reach{{9, 9, 9}, {-9, -9, -9}};
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j)
        for (int k = 0; k < n; ++k) {
          const Vec3d p{shape.half_extents.x * ((2 * i + 1.0) / n - 1), shape.half_extents.y * ((2 * j + 1.0) / n - 1),
                        shape.half_extents.z * ((2 * k + 1.0) / n - 1)};
          if (norm(nearest_in(shape, p) - p) > 1e-12) continue;
          inside += 1;
          first += p;
          second += scale(p, p);
          const Vec3d at = Vec3d{1, 2, 3} + rotate(q, p);
          for (int c = 0; c < 3; ++c) {
            reach.lower[c] = std::min(reach.lower[c], at[c]);
            reach.upper[c] = std::max(reach.upper[c], at[c]);
          }
        }
    const double piece = 8 * shape.half_extents.x * shape.half_extents.y * shape.half_extents.z / (double(n) * n * n);
    CHECK(volume_of(shape) == Approx(inside * piece).epsilon(0.01));
    CHECK(norm(first * (1 / inside)) < 0.005 * shape.half_length);
    const Vec3d mean = second * (1 / inside), inertia = inertia_of(shape, 1);
    CHECK(inertia.x == Approx(mean.y + mean.z).epsilon(0.01));
    CHECK(inertia.z == Approx(mean.x + mean.y).epsilon(0.01));
    for (int c = 0; c < 3; ++c) {
      CHECK(box.lower[c] <= reach.lower[c]);
      CHECK(box.upper[c] >= reach.upper[c]);
      CHECK(box.upper[c] - box.lower[c] < reach.upper[c] - reach.lower[c] + 0.002 + 0.004);
    }
  }
}

TEST_CASE("A cylinder that lies touches the plane along a line, as deep whatever way it has rolled") {
  const Shape drum = Shape::cylinder(0.05, 0.1);
  for (const double rolled : {0.0, 0.01, 0.1, 0.157, 0.3, 1.0, 3.0}) {
    const Posed pose{{0, 0, 0.0499}, turn({0, 1, 0}, rolled) * kLying};
    for (const bool box : {false, true}) {
      const Shape ground = box ? Shape::box({1, 1, 0.1}) : Shape::plane();
      const Manifold m = touch(ground, {{0, 0, box ? -0.1 : 0.0}, {}}, drum, pose, 1e-3);
      CAPTURE(rolled, box);
      REQUIRE(m.count >= 2);
      CHECK(norm(m.normal - Vec3d{0, 0, 1}) < 1e-9);
      double lowest = 0, highest = 0;
      for (std::uint32_t i = 0; i < m.count; ++i) {
        CHECK(m.points[i].separation == Approx(-1e-4).margin(1e-7));
        CHECK(std::abs(m.points[i].from_b.x) < 1e-4);  // the facet
        lowest = std::min(lowest, m.points[i].from_b.y);
        highest = std::max(highest, m.points[i].from_b.y);
      }
      CHECK(lowest == Approx(-0.1).margin(1e-3));
      CHECK(highest == Approx(0.1).margin(1e-3));
    }
  }
}

TEST_CASE("Spheres, boxes, cylinders and cones that are apart are found at their distance") {
  Random random(11);
  int pairs = 0, flat = 0, exact = 0;
  double worst = 0;
  for (int n = 0; n < 3000; ++n) {
    const Shape round = n % 2 == 0 ? Shape::cylinder(random(0.02, 0.06), random(0.01, 0.08))
                                   : Shape::cone(random(0.02, 0.06), random(0.02, 0.06));
    const std::uint64_t kind = random.below(4);
    const Shape other = kind == 0   ? Shape::sphere(random(0.01, 0.05))
                        : kind == 1 ? Shape::box({random(0.02, 0.05), random(0.02, 0.05), random(0.02, 0.05)})
                        : kind == 2 ? Shape::cylinder(random(0.02, 0.06), random(0.01, 0.08))
                                    : Shape::cone(random(0.02, 0.06), random(0.02, 0.06));
    const Posed a{{}, random.rotation()}, b{random.vector(0.1), random.rotation()};
    const Shape point = Shape::box({1e-9, 1e-9, 1e-9});
    const double apart = kind == 0 ? distance(round, a, point, b) - other.radius : distance(round, a, other, b);
    if (!(apart > 1e-5 && apart < 2e-3)) continue;
    ++pairs;
    const Manifold m = touch(round, a, other, b, 4e-3);
    CAPTURE(n, kind, apart);
    REQUIRE(m.count > 0);
    // Never farther than it is, up to what the polygons are inside the rims; nearer where they are apart corner to
    // corner.
    const double error = RoundHull::inscribed_error(round) + (kind > 1 ? RoundHull::inscribed_error(other) : 0);
    CHECK(least_separation(m) < apart + error);
    if (kind < 2) {  // against what is not round itself: exactly
      ++flat;
      exact += least_separation(m) < apart + 1e-5 ? 1 : 0;
    }
    worst = std::max(worst, apart - least_separation(m));
    if (kind == 0) CHECK(least_separation(m) == Approx(apart).margin(1e-6));
  }
  CHECK(pairs > 20);
  CHECK(exact > 0.8 * flat);
  CHECK(worst < 1e-3);
}

TEST_CASE("A contact on a cap is where the other body stands, however near to the middle line of the facet") {
  // Kinds of contact: a sphere's nearest point, and the corners of a thin card, which carry its centre between them.
  const double cap = 0.5;
  for (const Shape& round : {Shape::cylinder(cap, 0.02), Shape::cone(cap, 0.1)}) {
    const bool cone = round.kind == ShapeKind::kCone;
    const Quatd base_up = cone ? turn({1, 0, 0}, kPi) : Quatd{};
    const Posed pose{{0, 0, RoundHull::lower_end(round)}, base_up};  // the cap is the plane z = 0
    for (const double y : {0.0, 1e-4, -3e-4, 4.9e-4, 0.01}) {
      CAPTURE(cone, y);
      const Shape ball = Shape::sphere(0.008), card = Shape::box({0.03, 4e-4, 0.02});
      const Manifold under = touch(ball, {{0.05, y, 0.008}, {}}, round, pose, 1e-3);
      REQUIRE(under.count == 1);
      CHECK(under.normal.z == Approx(-1).epsilon(1e-12));
      CHECK(std::abs(under.points[0].from_a.x) < 1e-9);
      CHECK(std::abs(under.points[0].from_a.y) < 1e-9);
      const Manifold feet = touch(card, {{0.05, y, 0.02}, {}}, round, pose, 1e-3);
      REQUIRE(feet.count == 4);
      double beside = 0;
      for (const ManifoldPoint& p : std::span(feet.points).first(feet.count)) {
        CHECK(std::abs(p.from_a.y) == Approx(4e-4).epsilon(1e-6));
        beside += p.from_a.y;
      }
      CHECK(std::abs(beside) < 1e-9);
    }
  }
}

TEST_CASE("A marble and a card that stand on a cap beside the middle line of the facet stay there") {
  PhysicsBench bench;
  bench.world.insert(make_fixed_body(0, Shape::cylinder(0.5, 0.015), 0.4, {{0, 0, -0.015}, {}}));
  bench.add_sphere(1, 0.008, 0.005, 0.4, {0.05, 1e-4, 0.008});
  bench.add_box(2, {0.03, 4.5e-4, 0.015}, 0.002, 0.4, {{-0.1, 2e-4, 0.015}, {}});
  bench.run_seconds(3);
  for (const auto& [id, at] : {std::pair<BodyId, Vec3d>{1, {0.05, 1e-4, 0.008}}, {2, {-0.1, 2e-4, 0.015}}}) {
    CAPTURE(id);
    CHECK(bench.position(id).x == Approx(at.x).margin(1e-6));
    CHECK(bench.position(id).y == Approx(at.y).margin(1e-6));
    CHECK(bench.position(id).z == Approx(at.z).margin(2e-5));  // its weight, on the contact's stiffness
  }
  CHECK(bench.world.kinetic_energy() < 1e-12);
}

TEST_CASE("A cylinder rolls down an incline as the formula says, smoothly") {
  const double slope = 0.2, radius = 0.05;
  PhysicsBench bench;
  bench.settings.gravity = {kGravity * std::sin(slope), 0, -kGravity * std::cos(slope)};
  bench.world.insert(make_fixed_body(0, Shape::box({5, 1, 0.1}), 0.8, {{0, 0, -0.1}, {}}));
  bench.world.insert(make_dynamic_body(1, Shape::cylinder(radius, 0.08), 0.5, 0.8, {{-4, 0, radius}, kLying}));
  bench.run_seconds(0.5);
  const double begun = bench.velocity(1).linear.x;
  double least = 1e9, most = -1e9;
  for (int i = 0; i < 500; ++i) {
    const double before = bench.velocity(1).linear.x;
    bench.step();
    const double acceleration = (bench.velocity(1).linear.x - before) / bench.settings.dt;
    least = std::min(least, acceleration);
    most = std::max(most, acceleration);
  }
  const double expected = kGravity * std::sin(slope) / 1.5;  // I = m r^2 / 2
  CHECK((bench.velocity(1).linear.x - begun) / 0.5 == Approx(expected).epsilon(0.01));
  CHECK(least > 0.9 * expected);
  CHECK(most < 1.1 * expected);
  CHECK(bench.velocity(1).angular.y * radius == Approx(bench.velocity(1).linear.x).epsilon(0.01));
  CHECK(std::abs(bench.position(1).y) < 1e-3);
}

TEST_CASE("A cylinder that lies on a level box stays there, and one that rolls keeps its speed") {
  for (const double speed : {0.0, 0.01, 0.25}) {
    PhysicsBench bench;
    bench.settings.gravity = {0, 0, -kGravity};
    const double r = 0.01;
    bench.world.insert(make_fixed_body(0, Shape::box({0.05, 0.8, 0.01}), 0.5, {{0, 0, -0.01}, {}}));
    Body drum = make_dynamic_body(1, Shape::cylinder(r, 0.1), 0.3, 0.5, {{0, 0, r}, turn({0, 1, 0}, 0.5 * kPi)});
    drum.motion.velocity = {{0, speed, 0}, {-speed / r, 0, 0}};
    bench.world.insert(drum);
    bench.run_seconds(2);
    CAPTURE(speed);
    CHECK(bench.velocity(1).linear.y == Approx(speed).epsilon(0.01).margin(1e-6));
    CHECK(bench.position(1).y == Approx(2 * speed).epsilon(0.01).margin(1e-6));
  }
}

TEST_CASE("A cylinder rolls straight at any speed that a hand gives it, and does not sink") {
  for (const std::uint32_t sub_steps : {1u, 2u, 4u})
    for (const double speed : {1.0, 2.5, 5.0})
      for (const bool box : {false, true}) {
        CAPTURE(sub_steps, speed, box);
        const double r = 0.03;
        PhysicsBench bench;
        bench.settings.sub_steps = sub_steps;
        if (box)
          bench.world.insert(make_fixed_body(0, Shape::box({20, 1, 0.1}), 0.5, {{0, 0, -0.1}, {}}));
        else
          bench.add_ground(0, 0.5);
        Body drum = make_dynamic_body(1, Shape::cylinder(r, 0.05), 0.3, 0.5, {{0, 0, r}, kLying});
        drum.motion.velocity = {{speed, 0, 0}, {0, speed / r, 0}};
        bench.world.insert(drum);
        bench.run_seconds(3);
        const Vec3d& v = bench.velocity(1).linear;
        CHECK(std::abs(std::atan2(v.y, v.x)) < 2e-4);  // rad; before: 0.25 to 3
        CHECK(norm(v) == Approx(speed).epsilon(1e-3));
        CHECK(bench.position(1).z == Approx(r).margin(3e-5));  // its weight, on the contacts' stiffness; before: 120 um
      }
}

TEST_CASE("The wheels of an axle roll as a cylinder does, and a wheel beside the centre of its body does not") {
  const Shape wheel = Shape::cylinder(0.03, 0.01);
  const Quatd upright = kLying;
  const std::vector<CompoundPart> parts{{wheel, {{0, 0, -0.05}, {}}}, {wheel, {{0, 0, 0.05}, {}}}};
  Compound axle;
  axle.parts = parts;
  axle.half_extents = {0.03, 0.03, 0.06};
  axle.bounding_radius = 0.07;
  const std::vector<Compound> list{axle};
  const Body body = make_dynamic_body(1, compound_shape(list[0], 0), 0.3, 0.5, {{0, 0, 0.03}, upright});
  const auto touch_along = [](const Vec3d& normal) {
    Manifold touch;
    touch.normal = normal;
    touch.count = 2;
    return touch;
  };
  CHECK(touches_on_side(body, 0, list, touch_along({0, 0, 1})));
  CHECK(touches_on_side(body, 1, list, touch_along({0, 0, 1})));
  CHECK_FALSE(touches_on_side(body, 0, list, touch_along({0, 1, 0})));  // on its flat end
  const std::vector<CompoundPart> aside{{wheel, {{0.1, 0, 0}, {}}}};
  Compound beside = axle;
  beside.parts = aside;
  const std::vector<Compound> other{beside};
  CHECK_FALSE(touches_on_side(body, 0, other, touch_along({0, 0, 1})));
}

TEST_CASE("Cylinders stand on each other, a cone on its base, and a cone that lies on its side") {
  PhysicsBench bench;
  bench.world.insert(make_fixed_body(0, Shape::plane(), 0.5, {}));
  for (BodyId id = 1; id <= 6; ++id)
    bench.world.insert(
        make_dynamic_body(id, Shape::cylinder(0.03, 0.02), 0.2, 0.5, {{0, 0, 0.02 + 0.04 * (id - 1)}, {}}));
  const Shape cone = Shape::cone(0.04, 0.05);
  bench.world.insert(make_dynamic_body(7, cone, 0.2, 0.5, {{0.3, 0, 0.025}, {}}));
  // On its side: the axis is half the apex angle above the ground.
  const double half_angle = std::atan2(0.04, 0.1);
  const double height = 0.075 * std::sin(half_angle);  // of the centre of mass, from the apex along the axis
  bench.world.insert(make_dynamic_body(8, cone, 0.2, 0.5, {{0.6, 0, height}, turn({0, 1, 0}, 0.5 * kPi + half_angle)}));
  bench.run_seconds(5);
  for (BodyId id = 1; id <= 6; ++id) CHECK(norm(bench.position(id) - Vec3d{0, 0, 0.02 + 0.04 * (id - 1)}) < 2e-4);
  CHECK(norm(bench.position(7) - Vec3d{0.3, 0, 0.025}) < 2e-4);
  CHECK(bench.position(8).z == Approx(height).margin(2e-4));
  CHECK(bench.world.kinetic_energy() < 1e-9);
}

TEST_CASE("A cylinder that is not finite, or inside the other body, gives no contact or a finite one") {
  Random random(5);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Shape drum = Shape::cylinder(0.05, 0.1), box = Shape::box({0.2, 0.2, 0.2});
  CHECK(touch(box, {}, drum, {{nan, 0, 0}, {}}, 1e-3).count == 0);
  for (int n = 0; n < 500; ++n)
    for (const Shape& other : {box, drum, Shape::sphere(0.1), Shape::capsule(0.05, 0.1), Shape::cone(0.1, 0.05)}) {
      const Manifold m = touch(other, {{}, random.rotation()}, drum, {random.vector(0.05), random.rotation()}, 1e-3);
      REQUIRE(m.count > 0);
      CHECK(norm(m.normal) == Approx(1).epsilon(1e-6));
      for (std::uint32_t i = 0; i < m.count; ++i)
        CHECK((is_finite(m.points[i].from_a) && std::isfinite(m.points[i].separation)));
    }
}
