// The polygon over a face, and the four points that stand for it.
#include "rt/physics/box_clip.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <set>

using namespace tactus::physics;

namespace {

ClipPolygon<double> polygon_of(std::initializer_list<ClipPoint<double>> points) {
  ClipPolygon<double> polygon;
  for (const auto& p : points) polygon.points[polygon.count++] = p;
  return polygon;
}

ClipPolygon<double> square(double half, double w) {
  return polygon_of({{half, half, w, 3, 0}, {-half, half, w, 2, 1}, {-half, -half, w, 0, 2}, {half, -half, w, 1, 3}});
}

std::set<int> ids(const ClipPolygon<double>& polygon) {
  std::set<int> result;
  for (std::uint32_t i = 0; i < polygon.count; ++i) result.insert(polygon.points[i].id);
  return result;
}

// Eight corners at 45 degrees from each other, ids 0..7 in the order of the angle.
ClipPolygon<double> octagon() {
  ClipPolygon<double> polygon;
  for (std::uint8_t k = 0; k < 8; ++k) {
    const double angle = 0.78539816339744831 * k;
    polygon.points[polygon.count++] = {std::cos(angle), std::sin(angle), 0.0, k, k};
  }
  return polygon;
}

}  // namespace

TEST_CASE("A face inside the rectangle stays whole") {
  auto polygon = square(0.1, 0.001);
  clip_to_rectangle(polygon, 0.2, 0.1);
  REQUIRE(polygon.count == 4);
  REQUIRE(ids(polygon) == std::set<int>{0, 1, 2, 3});
}

TEST_CASE("A face larger than the rectangle is cut to it, at its own slope") {
  ClipPolygon<double> polygon = square(1.0, 0.0);
  for (auto& p : polygon.points) p.w = 0.1 * p.u + 0.2 * p.v + 0.5;
  clip_to_rectangle(polygon, 0.3, 0.2);
  REQUIRE(polygon.count == 4);
  for (std::uint32_t i = 0; i < 4; ++i) {
    const auto& p = polygon.points[i];
    REQUIRE(std::abs(p.u) == Approx(0.3).margin(1e-12));
    REQUIRE(std::abs(p.v) == Approx(0.2).margin(1e-12));
    REQUIRE(p.w == Approx(0.1 * p.u + 0.2 * p.v + 0.5).margin(1e-12));
    REQUIRE(p.id >= 8);
  }
  REQUIRE(ids(polygon).size() == 4);
}

TEST_CASE("A face beside the rectangle leaves nothing") {
  auto polygon = square(0.1, 0.0);
  for (auto& p : polygon.points) p.u += 0.5;
  clip_to_rectangle(polygon, 0.2, 0.2);
  REQUIRE(polygon.count == 0);
}

TEST_CASE("A corner beyond a side by less than the tolerance stays a corner") {
  for (const double beyond : {-9e-6, 0.0, 9e-6}) {
    auto polygon = square(0.1 + beyond, 0.0);
    clip_to_rectangle(polygon, 0.1, 0.1);
    REQUIRE(ids(polygon) == std::set<int>{0, 1, 2, 3});
  }
  auto polygon = square(0.1 + 11e-6, 0.0);
  clip_to_rectangle(polygon, 0.1, 0.1);
  REQUIRE(polygon.count == 4);
  REQUIRE(*ids(polygon).begin() >= 8);
}

TEST_CASE("A sliver narrower than 20 micrometres is a line of two points with the lesser depths") {
  auto polygon = polygon_of(
      {{0.1, 5e-6, 1e-6, 20, 0}, {-0.1, 5e-6, 2e-6, 30, 1}, {-0.1, -5e-6, 4e-6, 0, 2}, {0.1, -5e-6, 3e-6, 1, 3}});
  clip_to_rectangle(polygon, 0.2, 0.2);
  REQUIRE(ids(polygon) == std::set<int>{0, 1});
  for (std::uint32_t i = 0; i < 2; ++i) REQUIRE(polygon.points[i].w == (polygon.points[i].id == 1 ? 1e-6 : 2e-6));
}

TEST_CASE("Four points of an octagon are every other corner, whatever noise there is") {
  for (int noisy = 0; noisy < 8; ++noisy) {
    auto polygon = octagon();
    polygon.points[static_cast<std::size_t>(noisy)].w = -1e-9;
    polygon.points[static_cast<std::size_t>(noisy)].u *= 1 + 1e-6;
    reduce_to_four(polygon);
    REQUIRE(ids(polygon) == std::set<int>{0, 2, 4, 6});
  }
}

TEST_CASE("The deepest point is kept, and no depth is lost to the preference for the lower id") {
  auto polygon = octagon();
  polygon.points[5].w = -1e-3;
  reduce_to_four(polygon);
  REQUIRE(polygon.points[0].id == 5);
  REQUIRE(polygon.points[0].w == -1e-3);

  auto nearly = octagon();
  nearly.points[5].w = -5e-7;
  reduce_to_four(nearly);
  double least = 0;
  for (std::uint32_t i = 0; i < nearly.count; ++i) least = std::min(least, nearly.points[i].w);
  REQUIRE(least == -5e-7);
}
