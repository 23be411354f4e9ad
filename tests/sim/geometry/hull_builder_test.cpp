// The hull of points: what is on it, what is flat is one face, the same from the same, and what is refused.
#include "sim/geometry/hull_builder.h"

#include <catch2/catch.hpp>

#include "tests/support/physics_bench.h"

using namespace tactus;
using namespace tactus::sim;
using Catch::Matchers::Contains;

namespace {

std::vector<Vec3d> cube(double half) {
  std::vector<Vec3d> points;
  for (unsigned k = 0; k < 8; ++k) points.push_back({k & 1 ? half : -half, k & 2 ? half : -half, k & 4 ? half : -half});
  return points;
}

BuiltHull good(std::span<const Vec3d> points) {
  auto built = build_hull(points);
  INFO(built.message());
  REQUIRE(built.ok());
  return std::move(built).value();
}

std::vector<Vec3d> on_ball(test::Random& random, int count, double radius) {
  std::vector<Vec3d> points;
  while (static_cast<int>(points.size()) < count) {
    const Vec3d v = random.vector(1);
    if (norm(v) > 0.2 && norm(v) < 1) points.push_back(v * (radius / norm(v)));
  }
  return points;
}

}  // namespace

TEST_CASE("A cube with points inside, on its faces and twice has 8 vertices and 6 faces") {
  std::vector<Vec3d> points = cube(0.1);
  test::Random random(1);
  for (int n = 0; n < 200; ++n) points.push_back(random.vector(0.1));
  for (const Vec3d& v : cube(0.1)) points.push_back(v);
  points.push_back({0.1, 0, 0});
  points.push_back({0, 0, -0.1});
  const BuiltHull built = good(points);
  REQUIRE(built.vertices == cube(0.1));
  REQUIRE(built.hull.topology.faces == 6);
  REQUIRE(built.hull.topology.edges == 12);
  REQUIRE(built.hull.volume == Approx(0.008).epsilon(1e-12));
  REQUIRE(built.given_from_body.rotation == Quatd{});
}

TEST_CASE("A cube turned and rounded to single precision, far from the origin, still has 6 faces") {
  test::Random random(2);
  for (int n = 0; n < 50; ++n) {
    const Posed pose{random.vector(1), quat_from_rotation_vector(random.vector(2))};
    std::vector<Vec3d> points;
    for (const Vec3d& v : cube(0.05)) {
      const Vec3d p = pose * v;
      points.push_back({static_cast<double>(static_cast<float>(p.x)), static_cast<double>(static_cast<float>(p.y)),
                        static_cast<double>(static_cast<float>(p.z))});
    }
    const BuiltHull built = good(points);
    REQUIRE(built.hull.topology.faces == 6);
    REQUIRE(built.hull.volume == Approx(0.001).epsilon(1e-4));
    REQUIRE(built.hull.flatness < 1e-6);
  }
}

TEST_CASE("Points on a ball are all vertices, and the vertices alone give the same hull bit by bit") {
  test::Random random(3);
  for (const int count : {4, 8, 20, 64}) {
    std::vector<Vec3d> points = on_ball(random, count, 0.1);
    const std::vector<Vec3d> shell = points;
    for (int n = 0; n < 100; ++n) points.push_back(random.vector(0.005));
    const auto built = build_hull(points);
    if (count == 4 && !built.ok()) continue;
    REQUIRE(built.ok());
    const BuiltHull again = good(built.value().vertices);
    REQUIRE(built.value().hull == again.hull);
    REQUIRE(built.value().given_from_body == again.given_from_body);
    const auto& t = again.hull.topology;
    REQUIRE(t.vertices + t.faces == t.edges + 2);
    for (const Vec3d& p : points) {
      const Vec3d in_body = inverse(again.given_from_body) * p;
      for (std::uint32_t f = 0; f < t.faces; ++f)
        REQUIRE(dot(again.hull.normal(f), in_body) <= again.hull.offsets[f] + 1e-6);
    }
    if (count > 4) REQUIRE(again.vertices == shell);
  }
}

TEST_CASE("What makes no hull is refused with what would do") {
  const auto wrong = [](std::span<const Vec3d> points) {
    const auto built = build_hull(points);
    REQUIRE_FALSE(built.ok());
    return built.message();
  };
  std::vector<Vec3d> points = cube(0.1);
  CHECK_THAT(wrong(std::span(points).first(3)), Contains("3 points make no solid"));
  points[5].y = std::numeric_limits<double>::quiet_NaN();
  CHECK_THAT(wrong(points), Contains("not finite"));
  points = cube(0.1);
  for (Vec3d& p : points) p.z = 0.25;
  CHECK_THAT(wrong(points), Contains("lie in a plane"));
  points = cube(0.1);
  for (Vec3d& p : points) p.z *= 1e-4;
  CHECK_THAT(wrong(points), Contains("2e-05 m thick"));
  CHECK_THAT(wrong(std::vector<Vec3d>(10, Vec3d{1, 2, 3})), Contains("lie in a plane"));
  test::Random random(4);
  CHECK_THAT(wrong(on_ball(random, 200, 0.1)), Contains("the hull has 200 vertices; accepted: at most 64"));
}
