// A cylinder or a cone as a hull, rotated about its axis so that its surface is exact where it faces the other body.
//
// The rim is a polygon of kSides corners on the circle. One of its facets, kFacet wide, faces a given direction, so its
// plane is tangent to the surface there: contacts on the side, on the rim and on the cap have the depth and the normal
// of the round body, and a body that rolls has the same features in every step. Elsewhere the polygon is inside the
// circle by at most inscribed_error, 1.4 % of the radius; the contact of two rims that meet edge to edge is found late
// by that much. Rejected: a hull that turns with the body, which rolls over its corners (0.5 % of the radius with 32
// sides); a facet as wide as the others, on which a cylinder comes to rest. Frame: the body's: z along the axis, origin
// at the centre of mass. Units: m. Thread: [any]; pure. The object is the storage of its view and must outlive it.
#pragma once

#include <array>
#include <cmath>

#include "rt/physics/shapes/hull_view.h"

namespace tactus::physics {

namespace round_hull {

inline constexpr std::uint32_t kSides = 20;
// Half the angle of the facet that faces the other body [rad]: so narrow that a turn of 0.01 rad lifts its edge by less
// than a micrometre on a body of 100 mm.
inline constexpr double kFacet = 5e-4;
inline constexpr double kStep = (2.0 * 3.14159265358979323846 - 2.0 * kFacet) / (kSides - 1);  // angle of the others

// Power series about 0, for |x| <= 2 pi: at compile time, with the same bits from every compiler.
constexpr double cosine(double x) noexcept {
  double sum = 1.0, term = 1.0;
  for (int k = 1; k < 30; ++k) {
    term *= -x * x / ((2 * k - 1) * (2 * k));
    sum += term;
  }
  return sum;
}
constexpr double sine(double x) noexcept {
  double sum = x, term = x;
  for (int k = 1; k < 30; ++k) {
    term *= -x * x / ((2 * k) * (2 * k + 1));
    sum += term;
  }
  return sum;
}

// Unit vectors to the corners and to the middles of the facets; facet i is between corners i and i + 1.
struct Ring {
  std::array<double, kSides> x{}, y{}, middle_x{}, middle_y{};
};
constexpr Ring make_ring() noexcept {
  Ring ring;
  for (std::uint32_t i = 0; i < kSides; ++i) {
    const double angle = i == 0 ? -kFacet : kFacet + (i - 1) * kStep;
    const double middle = i == 0 ? 0.0 : angle + 0.5 * kStep;
    ring.x[i] = cosine(angle);
    ring.y[i] = sine(angle);
    ring.middle_x[i] = cosine(middle);
    ring.middle_y[i] = sine(middle);
  }
  return ring;
}
inline constexpr Ring kRing = make_ring();
inline constexpr double kHalfCosine = cosine(0.5 * kStep), kFacetCosine = cosine(kFacet);

// Corners of the lower rim first, then those of the upper one, or the apex. Faces: caps first, then the facets.
constexpr HullTopology make_topology(bool cone) noexcept {
  HullTopology t;
  t.vertices = cone ? kSides + 1 : 2 * kSides;
  std::array<std::uint8_t, kSides> cap{};
  for (std::uint32_t i = 0; i < kSides; ++i) cap[i] = static_cast<std::uint8_t>(kSides - 1 - i);
  (void)t.add_face(cap);
  for (std::uint32_t i = 0; i < kSides; ++i) cap[i] = static_cast<std::uint8_t>(kSides + i);
  if (!cone) (void)t.add_face(cap);
  for (std::uint32_t i = 0; i < kSides; ++i) {
    const auto low = static_cast<std::uint8_t>(i), next = static_cast<std::uint8_t>((i + 1) % kSides);
    const std::array<std::uint8_t, 4> side{low, next, static_cast<std::uint8_t>(kSides + (cone ? 0 : next)),
                                           static_cast<std::uint8_t>(kSides + low)};
    (void)t.add_face(std::span(side).first(cone ? 3 : 4));
  }
  (void)t.close();
  return t;
}
inline constexpr HullTopology kCylinder = make_topology(false), kCone = make_topology(true);
static_assert(kCylinder.edges == 3 * kSides && kCone.edges == 2 * kSides);

}  // namespace round_hull

// The unit vector in the plane across the axis to which the facet turns.
struct Alignment {
  double x{1.0}, y{0.0};

  // Below this share of the direction the part across the axis is mostly noise, as of a body that stands on its cap:
  // then the facet stays where it is in the body. There the rim is off by inscribed_error times this share.
  static constexpr double kLeast = 0.02;

  // `toward`: to the other body, of any length, in the body's frame.
  static Alignment to(const Vec3d& toward) noexcept {
    if (!faces(toward)) return {};
    const double across = across_axis(toward);
    return {toward.x / across, toward.y / across};
  }

  // True if the facet turns to this direction: the contact is on the side or at the rim. False on a cap.
  static bool faces(const Vec3d& toward) noexcept { return across_axis(toward) > kLeast * norm(toward); }

 private:
  static double across_axis(const Vec3d& v) noexcept { return std::sqrt(v.x * v.x + v.y * v.y); }
};

class RoundHull {
 public:
  // `shape`: a cylinder or a cone.
  RoundHull(const Shape& shape, const Alignment& to) noexcept : cone_(shape.kind == ShapeKind::kCone) {
    using namespace round_hull;
    const double r = shape.radius, low = lower_end(shape), high = low + 2.0 * shape.half_length;
    for (std::uint32_t i = 0; i < kSides; ++i) {
      x_[i] = r * (to.x * kRing.x[i] - to.y * kRing.y[i]);
      y_[i] = r * (to.y * kRing.x[i] + to.x * kRing.y[i]);
      z_[i] = low;
    }
    for (std::uint32_t i = kSides; i < kVertices; ++i) {
      const bool rim = !cone_;
      const std::uint32_t below = i - kSides;
      x_[i] = rim ? x_[below] : i == kSides ? 0.0 : x_[0];
      y_[i] = rim ? y_[below] : i == kSides ? 0.0 : y_[0];
      z_[i] = rim || i == kSides ? high : z_[0];
    }
    add_face(0, {0.0, 0.0, -1.0}, -low);
    if (!cone_) add_face(1, {0.0, 0.0, 1.0}, high);
    const std::uint32_t caps = cone_ ? 1 : 2;
    for (std::uint32_t i = 0; i < kSides; ++i) {
      const double middle_x = to.x * kRing.middle_x[i] - to.y * kRing.middle_y[i];
      const double middle_y = to.y * kRing.middle_x[i] + to.x * kRing.middle_y[i];
      const double apothem = r * (i == 0 ? kFacetCosine : kHalfCosine);
      const Slope slope = slope_of(apothem, shape.half_length);
      add_face(caps + i, {middle_x * slope.across, middle_y * slope.across, slope.along},
               cone_ ? slope.along * high : apothem);
    }
    for (std::uint32_t f = caps + kSides; f < kFaces; ++f) add_face(f, {nx_[0], ny_[0], nz_[0]}, offsets_[0]);
    const Slope widest = slope_of(r, shape.half_length);
    const double side_secant = 1.0 / kHalfCosine, cap_secant = 1.0 / std::sqrt(0.5 * (1.0 - widest.along));
    const HullTopology& topology = cone_ ? kCone : kCylinder;
    for (std::uint32_t e = 0; e < topology.edges; ++e)
      secant_[e] = topology.edge[e].left < caps || topology.edge[e].right < caps ? cap_secant : side_secant;
    largest_secant_ = larger(side_secant, cap_secant);
    inner_radius_ = smaller(-low, cone_ ? slope_of(r * kHalfCosine, shape.half_length).along * high : r * kHalfCosine);
  }

  HullView view() const noexcept {
    return {.topology = cone_ ? &round_hull::kCone : &round_hull::kCylinder,
            .x = x_,
            .y = y_,
            .z = z_,
            .nx = nx_,
            .ny = ny_,
            .nz = nz_,
            .offsets = offsets_,
            .padded = cone_ ? kConeVertices : kVertices,
            .padded_faces = kFaces,
            .edge_secant = secant_,
            .largest_secant = largest_secant_,
            .inner_radius = inner_radius_,
            .flatness = 0.0};
  }

  // How far the polygon is inside the circle, at most [m].
  static double inscribed_error(const Shape& shape) noexcept { return shape.radius * (1.0 - round_hull::kHalfCosine); }

  // z of the lower cap, from the centre of mass [m].
  static constexpr double lower_end(const Shape& shape) noexcept {
    return shape.kind == ShapeKind::kCone ? -0.5 * shape.half_length : -shape.half_length;
  }

 private:
  static constexpr std::uint32_t kVertices = 2 * round_hull::kSides, kFaces = 24;  // fill whole registers
  static constexpr std::uint32_t kConeVertices = 24;
  static_assert(round_hull::kSides + 2 <= kFaces && round_hull::kSides + 1 <= kConeVertices);

  // A side's normal: the part across the axis, the part along it.
  struct Slope {
    double across, along;
  };
  Slope slope_of(double apothem, double half_length) const noexcept {
    if (!cone_) return {1.0, 0.0};
    const double length = std::sqrt(apothem * apothem + 4.0 * half_length * half_length);
    return {2.0 * half_length / length, apothem / length};
  }
  void add_face(std::uint32_t face, const Vec3d& n, double offset) noexcept {
    nx_[face] = n.x;
    ny_[face] = n.y;
    nz_[face] = n.z;
    offsets_[face] = offset;
  }

  bool cone_;
  alignas(32) double x_[kVertices], y_[kVertices], z_[kVertices];
  alignas(32) double nx_[kFaces], ny_[kFaces], nz_[kFaces], offsets_[kFaces];
  double secant_[3 * round_hull::kSides];
  double largest_secant_{}, inner_radius_{};
};

}  // namespace tactus::physics
