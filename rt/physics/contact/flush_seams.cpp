#include "rt/physics/contact/flush_seams.h"

#include <algorithm>
#include <cmath>

#include "rt/physics/collision/collide.h"
#include "rt/physics/shapes/compound.h"
#include "rt/physics/shapes/shape_extent.h"

namespace tactus::physics {
namespace {

constexpr double kFlushShare = 0.02;                // of the thinner half
constexpr double kAcross = 0.5, kParallel = 0.999;  // cosines
constexpr double kRotation = 0.05;                  // most change of a cosine while a contact is carried over
// m: a contact is along the axis of the least overlap, but for a preference; so on a seam it is no deeper. And so no
// contact that is left out lets a body in farther than this.
constexpr double kDeepest = 1.1 * kFlush + 1e-5;
constexpr double kNear = 2.0 * kFlush;  // m, of the contact's points from the face's plane

double deepest_of(const Contact& contact) noexcept {
  double deepest = contact.points[0].separation;
  for (std::uint32_t i = 1; i < contact.count; ++i) deepest = std::min(deepest, contact.points[i].separation);
  return deepest;
}

// Whether all points are in a strip of the width that points near one edge have. Most contacts are not, and their first
// three points say so.
bool is_strip(const Contact& contact, double width) noexcept {
  const auto from_first = [&](std::uint32_t i) noexcept { return contact.points[i].from_a - contact.points[0].from_a; };
  const auto is_narrow = [width](const Vec3d& along, const Vec3d& to) noexcept {
    return norm_squared(cross(along, to)) <= width * width * std::max(norm_squared(along), norm_squared(to));
  };
  if (contact.count < 3) return true;
  const Vec3d first = from_first(1), second = from_first(2);
  if (!is_narrow(first, second)) return false;
  const Vec3d& along = norm_squared(first) > norm_squared(second) ? first : second;
  for (std::uint32_t i = 3; i < contact.count; ++i)
    if (!is_narrow(along, from_first(i))) return false;
  return true;
}

// m; a mesh is a surface, and has no thickness.
double flush_within(const Shape& slider, const Shape& tile) noexcept {
  const double thinner =
      tile.kind == ShapeKind::kMesh ? half_thickness(slider) : std::min(half_thickness(slider), half_thickness(tile));
  return std::min(kFlush, kFlushShare * thinner);
}

Vec3d in_axes(const Axes& axes, const Vec3d& v) noexcept { return {dot(axes.x, v), dot(axes.y, v), dot(axes.z, v)}; }

}  // namespace

// One of the two bodies of a contact, and the part of it that touches.
struct FlushSeams::Side {
  const Body& body;
  const BodyFrame& frame;
  const CompoundPart* part;  // null: the body is no compound

  const Shape& shape() const noexcept { return part != nullptr ? part->shape : body.shape; }
  Vec3d direction(const Vec3d& world) const noexcept {  // in the shape's frame
    const Vec3d own = in_axes(frame.axes, world);
    return part != nullptr ? rotate_inverse(part->body_from_part.rotation, own) : own;
  }
  // `from_centre`: from the body's centre, world axes; in the shape's frame.
  Vec3d point(const Vec3d& from_centre) const noexcept {
    const Vec3d own = in_axes(frame.axes, from_centre);
    return part != nullptr ? rotate_inverse(part->body_from_part.rotation, own - part->body_from_part.position) : own;
  }
  Vec3d centre() const noexcept {  // of the shape's frame, in the world
    if (part == nullptr) return frame.position;
    const Vec3d& at = part->body_from_part.position;
    return frame.position + frame.axes.x * at.x + frame.axes.y * at.y + frame.axes.z * at.z;
  }
  Vec3d to_world(const Vec3d& direction) const noexcept {
    const Vec3d own = part != nullptr ? rotate(part->body_from_part.rotation, direction) : direction;
    return frame.axes.x * own.x + frame.axes.y * own.y + frame.axes.z * own.z;
  }
};

FlushSeams::FlushSeams(const Capacities& capacities)
    : marks_(capacities.contacts), first_(capacities.bodies + 1), listed_(2 * capacities.contacts) {}

FlushSeams::Side FlushSeams::side_of(const TouchingBodies& bodies, const Contact& contact, bool b) noexcept {
  const bool fixed = b && contact.b_fixed;
  const std::uint32_t slot = b ? contact.slot_b : contact.slot_a;
  const Body& body = fixed ? bodies.fixed[slot] : bodies.moving[slot];
  const CompoundPart* part = body.shape.kind == ShapeKind::kCompound
                                 ? &bodies.shapes.compounds[body.shape.index].parts[contact.key.part_of(body.id)]
                                 : nullptr;
  return {body, fixed ? bodies.fixed_frames[slot] : bodies.frames[slot], part};
}

// Calls `f` with the normal, in the world, of each face of the tile that bounds the slider from below, within t and
// `slack` [m].
template <class F>
void FlushSeams::for_each_flush_face(const TouchingBodies& bodies, const Contact& contact, bool b_over_a, double slack,
                                     F&& f) noexcept {
  const Side tile = side_of(bodies, contact, !b_over_a);
  if (!has_flat_faces(tile.shape().kind)) return;
  const Side slider = side_of(bodies, contact, b_over_a);
  const auto point = [&](std::uint32_t i) noexcept {
    return tile.point(b_over_a ? contact.points[i].from_a : contact.points[i].from_b);
  };
  const FacesWanted wanted{.p = point(0),
                           .reach = kNear + slack,
                           .n = tile.direction(contact.normal),
                           .most = slack > 0.0 ? kAcross + kRotation : kAcross};
  const auto try_face = [&](const FlatFace& face) noexcept {
    for (std::uint32_t i = 1; i < contact.count; ++i)
      if (!(std::abs(dot(face.normal, point(i)) - face.offset) <= wanted.reach)) return;
    const double flush = flush_within(slider.shape(), tile.shape());
    const Vec3d m = tile.to_world(face.normal);
    const double lowest = dot(m, slider.centre() - tile.centre()) -
                          extent_along(slider.shape(), bodies.shapes.hulls, slider.direction(-m));
    if (std::abs(lowest - face.offset) <= flush + slack) f(m, flush);
  };
  if (tile.shape().kind != ShapeKind::kMesh) return for_each_face(tile.shape(), bodies.shapes.hulls, wanted, try_face);
  const MeshPatch& patch = bodies.shapes.meshes[tile.shape().index].patch_of(contact.key);
  const FlatFace face{patch.normal, patch.offset};
  if (wanted.holds(face)) try_face(face);
}

void FlushSeams::list_contacts_of(std::size_t bodies, std::span<const Contact> contacts) noexcept {
  first_.resize(static_cast<std::uint32_t>(bodies) + 1);
  std::fill(first_.begin(), first_.end(), 0u);
  const auto for_each_end = [&](auto&& f) noexcept {
    for (std::uint32_t i = 0; i < contacts.size(); ++i) {
      f(contacts[i].slot_a, i);
      if (!contacts[i].b_fixed) f(contacts[i].slot_b, i);
    }
  };
  for_each_end([&](std::uint32_t slot, std::uint32_t) noexcept { ++first_[slot + 1]; });
  for (std::uint32_t slot = 1; slot < first_.size(); ++slot) first_[slot] += first_[slot - 1];
  listed_.resize(first_[first_.size() - 1]);
  for_each_end([&](std::uint32_t slot, std::uint32_t contact) noexcept { listed_[first_[slot]++] = contact; });
  for (std::uint32_t slot = first_.size() - 1; slot > 0; --slot) first_[slot] = first_[slot - 1];
  first_[0] = 0;
}

bool FlushSeams::passes_over(const TouchingBodies& bodies, std::span<const Contact> contacts, std::uint32_t number,
                             bool b_over_a) const noexcept {
  const Contact& contact = contacts[number];
  if (deepest_of(contact) < -kDeepest) return false;
  const std::uint32_t slot = b_over_a ? contact.slot_b : contact.slot_a;
  bool passes = false;
  for_each_flush_face(bodies, contact, b_over_a, 0.0, [&](const Vec3d& m, double flush) noexcept {
    for (std::uint32_t k = first_[slot]; k < first_[slot + 1] && !passes; ++k) {
      const Contact& other = contacts[listed_[k]];
      const Vec3d up = other.slot_a == slot ? -other.normal : other.normal;
      passes = dot(m, up) > kParallel && deepest_of(other) <= flush && !other.is_redundant() &&
               other.key.of_bodies() != contact.key.of_bodies();
    }
  });
  return passes;
}

void FlushSeams::mark(const TouchingBodies& bodies, double carried, std::span<Contact> contacts) noexcept {
  marks_.resize(static_cast<std::uint32_t>(contacts.size()));
  bool any = false;
  for (std::uint32_t i = 0; i < contacts.size(); ++i) {
    Contact& contact = contacts[i];
    marks_[i] = 0;
    if (!contact.may_be_flush || contact.is_redundant()) continue;
    const auto find = [&](bool b_over_a, Mark mark) noexcept {
      for_each_flush_face(bodies, contact, b_over_a, carried,
                          [&](const Vec3d&, double) noexcept { marks_[i] |= mark; });
    };
    if (deepest_of(contact) >= -kDeepest - carried && is_strip(contact, 2.0 * (kNear + carried))) {
      find(false, kAOverB);
      if (!contact.b_fixed) find(true, kBOverA);
    }
    contact.may_be_flush = marks_[i] != 0;
    any = any || contact.may_be_flush;
  }
  if (!any) return;
  list_contacts_of(bodies.moving.size(), contacts);
  for (std::uint32_t i = 0; i < contacts.size(); ++i)
    marks_[i] = ((marks_[i] & kAOverB) != 0 && passes_over(bodies, contacts, i, false)) ||
                ((marks_[i] & kBOverA) != 0 && passes_over(bodies, contacts, i, true));
  for (std::uint32_t i = 0; i < contacts.size(); ++i) {
    if (marks_[i] == 0) continue;
    for (ContactPoint& point : contacts[i].points) {
      point.redundant = true;
      point.normal_impulse = point.tangent_impulse[0] = point.tangent_impulse[1] = 0.0;
    }
  }
}

}  // namespace tactus::physics
