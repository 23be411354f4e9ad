#include "rt/physics/contact/redundant_points.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "rt/physics/contact/find_contacts.h"
#include "rt/physics/shapes/shape_contains.h"

namespace tactus::physics {
namespace {

// True if `p` [m, from the body's centre, world axes] is in a part of the body other than `part`.
bool is_in_other_part(const Body& body, std::uint32_t part, const ShapeLists& shapes, const Vec3d& p,
                      double margin) noexcept {
  const auto parts = shapes.compounds[body.shape.index].parts;
  const Vec3d at = rotate_inverse(body.motion.pose.rotation, p);
  for (std::uint32_t other = 0; other < parts.size(); ++other) {
    if (other == part) continue;
    const Posed& pose = parts[other].body_from_part;
    if (contains(parts[other].shape, shapes.hulls, rotate_inverse(pose.rotation, at - pose.position), margin))
      return true;
  }
  return false;
}

// True if the face of A (side 1) or B (-1) that is touched lies inside its body. A point is midway between the
// surfaces; just beyond A's surface, along the normal, is another part of A.
bool is_inside_body(const Body& body, const Contact& contact, double side, const ShapeLists& shapes,
                    double slop) noexcept {
  if (body.shape.kind != ShapeKind::kCompound) return false;
  const std::uint32_t part = contact.key.part_of(body.id);
  for (std::uint32_t i = 0; i < contact.count; ++i) {
    const ContactPoint& point = contact.points[i];
    const Vec3d beyond =
        (side > 0 ? point.from_a : point.from_b) + (side * (2.0 * slop - 0.5 * point.separation)) * contact.normal;
    if (!is_in_other_part(body, part, shapes, beyond, slop)) return false;
  }
  return true;
}

void mark_inner_faces(const TouchingBodies& bodies, double slop, std::span<Contact> of_pair) noexcept {
  const Body& a = bodies.moving[of_pair[0].slot_a];
  const Body& b = of_pair[0].b_fixed ? bodies.fixed[of_pair[0].slot_b] : bodies.moving[of_pair[0].slot_b];
  for (Contact& contact : of_pair) {
    const bool inner =
        is_inside_body(a, contact, 1.0, bodies.shapes, slop) || is_inside_body(b, contact, -1.0, bodies.shapes, slop);
    if (inner) contact.leave_out();
  }
}

// Angle between two normals [rad] below which they count as normals of one face: a carried-over contact keeps its
// normal while the bodies tilt, and a recomputed one has the normal of either body's face. The gaps are compared in any
// case. Measured range (2026-11-27): stacks of eight blocks of 2 to 16 slices come to rest alike from 0.001 to 0.1; at
// 7e-5 blocks of 3 to 8 slices vibrate.
constexpr double kMostTilt = 0.01;

// A contact point: x and y along the tangents of the contact plane, and the two quantities that must be linear in x and
// y, the height along the normal and the gap. All in m.
struct Place {
  double x, y, height, gap;
  ContactPoint* point;
};

double cross_of(const Place& from, const Place& p, const Place& q) noexcept {
  return (p.x - from.x) * (q.y - from.y) - (p.y - from.y) * (q.x - from.x);
}
double distance_squared(const Place& p, const Place& q) noexcept {
  return (p.x - q.x) * (p.x - q.x) + (p.y - q.y) * (p.y - q.y);
}

// True if, within the slop, the gap at p is no less than the weighted mean of the corners' gaps, and its height equal
// to that of their heights. The weights add up to 1.
bool follows(const Place& p, const Place (&corner)[3], const double (&weight)[3], double slop) noexcept {
  double gap = 0.0, height = 0.0;
  for (int i = 0; i < 3; ++i) {
    gap += weight[i] * corner[i].gap;
    height += weight[i] * corner[i].height;
  }
  return p.gap >= gap - slop && std::abs(p.height - height) <= slop;
}

bool follows_from_triangle(const Place& p, const Place (&corner)[3], double slop) noexcept {
  const double area = cross_of(corner[0], corner[1], corner[2]);
  if (area == 0.0) return false;
  double weight[3];
  for (int i = 0; i < 3; ++i) {
    const Place &q = corner[(i + 1) % 3], &r = corner[(i + 2) % 3];
    weight[i] = cross_of(p, q, r) / area;
    // Outside, by more than the slop from the edge q r.
    if (weight[i] < 0.0 && weight[i] * weight[i] * area * area > slop * slop * distance_squared(q, r)) return false;
  }
  return follows(p, corner, weight, slop);
}

bool follows_from_edge(const Place& p, const Place& a, const Place& b, double slop) noexcept {
  const double length_squared = distance_squared(a, b);
  const double along = (p.x - a.x) * (b.x - a.x) + (p.y - a.y) * (b.y - a.y);
  const double t = length_squared > 0.0 ? std::clamp(along / length_squared, 0.0, 1.0) : 0.0;
  const Place on_edge{
      .x = a.x + t * (b.x - a.x), .y = a.y + t * (b.y - a.y), .height = 0.0, .gap = 0.0, .point = nullptr};
  return distance_squared(p, on_edge) <= slop * slop && follows(p, {a, b, b}, {1.0 - t, t, 0.0}, slop);
}

// The contacts of two bodies, by normal.
class Planes {
 public:
  Planes(std::span<Contact> contacts, double slop) noexcept : contacts_(contacts), slop_(slop) {
    for (const Contact& contact : contacts_)
      if (count_ < kMaxContactPlanes && !contact.is_redundant() && plane_of(contact) == count_)
        first_[count_++] = &contact;
  }

  void mark() noexcept {
    for (std::uint32_t plane = 0; plane < count_; ++plane) mark_in(plane);
  }

 private:
  std::uint32_t plane_of(const Contact& contact) const noexcept {
    std::uint32_t plane = 0;
    while (plane < count_ && norm_squared(first_[plane]->normal - contact.normal) > kMostTilt * kMostTilt) ++plane;
    return plane;
  }

  template <class F>
  void for_each(std::uint32_t plane, F&& f) const noexcept {
    const Vec3d& n = first_[plane]->normal;
    const Tangents<double> tangents = tangents_of(n);
    for (Contact& contact : contacts_) {
      if (plane_of(contact) != plane) continue;
      for (std::uint32_t i = 0; i < contact.count; ++i) {
        ContactPoint& p = contact.points[i];
        if (!p.redundant || p.normal_impulse != 0.0)
          f(Place{.x = dot(tangents.t1, p.from_a),
                  .y = dot(tangents.t2, p.from_a),
                  .height = dot(n, p.from_a),
                  .gap = p.separation,
                  .point = &p});
      }
    }
  }
  // The first point for which `measure` is greatest.
  template <class F>
  Place farthest(std::uint32_t plane, F&& measure) const noexcept {
    Place best{};
    double most = 0.0;
    for_each(plane, [&](const Place& p) noexcept {
      const double value = measure(p);
      if (best.point != nullptr && value <= most) return;
      best = p;
      most = value;
    });
    return best;
  }

  void mark_in(std::uint32_t plane) noexcept {
    Place any{};
    for_each(plane, [&](const Place& p) noexcept {
      if (any.point == nullptr) any = p;
    });
    // Corners of the face: the ends of a diagonal, and the farthest to both sides of it.
    const Place a = farthest(plane, [&](const Place& p) noexcept { return distance_squared(any, p); });
    const Place b = farthest(plane, [&](const Place& p) noexcept { return distance_squared(a, p); });
    const Place c = farthest(plane, [&](const Place& p) noexcept { return cross_of(a, b, p); });
    const Place d = farthest(plane, [&](const Place& p) noexcept { return -cross_of(a, b, p); });
    const Place left[3] = {a, b, c}, right[3] = {a, b, d};
    for_each(plane, [&](const Place& p) noexcept {
      if (p.point == a.point || p.point == b.point) return;
      if (follows_from_edge(p, a, b, slop_)) p.point->redundant = true;
      if (p.point == c.point || p.point == d.point) return;
      if (follows_from_triangle(p, left, slop_) || follows_from_triangle(p, right, slop_)) p.point->redundant = true;
    });
    for_each(plane, [&](const Place& p) noexcept {
      if (p.point->redundant) hand_on(plane, p);
    });
  }

  void hand_on(std::uint32_t plane, const Place& from) noexcept {
    ContactPoint& point = *from.point;
    if (point.normal_impulse == 0.0 && point.tangent_impulse[0] == 0.0 && point.tangent_impulse[1] == 0.0) return;
    const Place to = farthest(plane, [&](const Place& p) noexcept {
      return p.point->redundant ? -std::numeric_limits<double>::max() : -distance_squared(p, from);
    });
    to.point->normal_impulse += point.normal_impulse;
    for (int i = 0; i < 2; ++i) to.point->tangent_impulse[i] += point.tangent_impulse[i];
    point.normal_impulse = point.tangent_impulse[0] = point.tangent_impulse[1] = 0.0;
  }

  std::span<Contact> contacts_;
  double slop_;
  const Contact* first_[kMaxContactPlanes]{};  // with each normal
  std::uint32_t count_{0};
};

}  // namespace

void mark_redundant_points(const TouchingBodies& bodies, double slop, std::span<Contact> contacts) noexcept {
  for (std::size_t k = 0; k < contacts.size();) {
    const auto of_pair = contacts.subspan(k, contacts_of_first_pair(contacts.subspan(k)).size());
    if (of_pair.size() > 1) {
      mark_inner_faces(bodies, slop, of_pair);
      Planes(of_pair, slop).mark();
    }
    k += of_pair.size();
  }
}

}  // namespace tactus::physics
