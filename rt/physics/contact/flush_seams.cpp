#include "rt/physics/contact/flush_seams.h"

#include <algorithm>
#include <cmath>

#include "rt/physics/collision/collide.h"
#include "rt/physics/shapes/compound.h"
#include "rt/physics/shapes/shape_extent.h"

namespace tactus::physics {
namespace {

constexpr double kFlushShare = 0.02;  // of the thinner half
constexpr double kParallel = 0.999;   // a cosine
// m: a contact is along the axis of the least overlap, but for a preference; so on a seam it is no deeper. And so no
// contact that is left out lets a body in farther than this.
constexpr double kDeepest = 1.1 * kFlush + 1e-5;
constexpr double kNear = 2.0 * kFlush;  // m, of the contact's points from the face's plane

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

PosedPart side_of(const TouchingBodies& bodies, const Contact& contact, bool b) noexcept {
  const std::uint32_t slot = b ? contact.slot_b : contact.slot_a;
  const Body& body = b && contact.b_fixed ? bodies.fixed[slot] : bodies.moving[slot];
  return part_of({body.shape, body.motion.pose}, contact.key.part_of(body.id), bodies.shapes.compounds);
}

// Calls `f` with the normal, in the world, of each face of the tile that bounds the slider from below, within t and
// `slack` [m].
template <class F>
void for_each_flush_face(const TouchingBodies& bodies, const Contact& contact, bool b_over_a, double slack,
                         F&& f) noexcept {
  const PosedPart tile = side_of(bodies, contact, !b_over_a);
  if (!traits_of(tile.shape.kind).has_faces) return;
  const PosedPart slider = side_of(bodies, contact, b_over_a);
  const Hulls hulls = bodies.shapes.hulls;
  const auto point = [&](std::uint32_t i) noexcept {  // in the tile's frame
    const Vec3d& from_body = b_over_a ? contact.points[i].from_a : contact.points[i].from_b;
    return rotate_inverse(tile.pose.rotation, from_body - tile.from_body);
  };
  const FacesWanted wanted{.p = point(0),
                           .reach = kNear + slack,
                           .n = rotate_inverse(tile.pose.rotation, contact.normal),
                           .most = slack > 0.0 ? kAcrossCarried : kAcross};
  const auto try_face = [&](const FlatFace& face) noexcept {
    for (std::uint32_t i = 1; i < contact.count; ++i)
      if (!(std::abs(dot(face.normal, point(i)) - face.offset) <= wanted.reach)) return;
    const double flush = flush_within(slider.shape, tile.shape);
    const Vec3d m = rotate(tile.pose.rotation, face.normal);
    const double lowest = dot(m, slider.pose.position - tile.pose.position) -
                          extent_along(slider.shape, hulls, rotate_inverse(slider.pose.rotation, -m));
    if (std::abs(lowest - face.offset) <= flush + slack) f(m, flush);
  };
  if (tile.shape.kind != ShapeKind::kMesh) return for_each_face(tile.shape, hulls, wanted, try_face);
  const MeshPatch& patch = bodies.shapes.meshes[tile.shape.index].patch_of(contact.key);
  const FlatFace face{patch.normal, patch.offset};
  if (wanted.holds(face)) try_face(face);
}

}  // namespace

FlushSeams::FlushSeams(const Capacities& capacities)
    : on_seam_(capacities.contacts), first_(capacities.bodies + 1), listed_(2 * capacities.contacts) {}

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
  if (contact.least_separation() < -kDeepest) return false;
  const std::uint32_t slot = b_over_a ? contact.slot_b : contact.slot_a;
  bool passes = false;
  for_each_flush_face(bodies, contact, b_over_a, 0.0, [&](const Vec3d& m, double flush) noexcept {
    for (std::uint32_t k = first_[slot]; k < first_[slot + 1] && !passes; ++k) {
      const Contact& other = contacts[listed_[k]];
      const Vec3d up = other.slot_a == slot ? -other.normal : other.normal;
      passes = dot(m, up) > kParallel && other.least_separation() <= flush && !other.is_redundant() &&
               other.key.of_bodies() != contact.key.of_bodies();
    }
  });
  return passes;
}

void FlushSeams::mark(const TouchingBodies& bodies, double carried, std::span<Contact> contacts) noexcept {
  bool any = false;
  for (Contact& contact : contacts) {
    if (!contact.may_be_flush || contact.is_redundant()) continue;
    const auto may_pass = [&](bool b_over_a) noexcept {
      bool found = false;
      for_each_flush_face(bodies, contact, b_over_a, carried, [&](const Vec3d&, double) noexcept { found = true; });
      return found;
    };
    contact.may_be_flush = contact.least_separation() >= -kDeepest - carried &&
                           is_strip(contact, 2.0 * (kNear + carried)) &&
                           (may_pass(false) || (!contact.b_fixed && may_pass(true)));
    any = any || contact.may_be_flush;
  }
  if (!any) return;
  list_contacts_of(bodies.moving.size(), contacts);
  on_seam_.clear();
  for (std::uint32_t i = 0; i < contacts.size(); ++i)
    if (contacts[i].may_be_flush && !contacts[i].is_redundant() &&
        (passes_over(bodies, contacts, i, false) || (!contacts[i].b_fixed && passes_over(bodies, contacts, i, true))))
      (void)on_seam_.try_push(i);
  for (const std::uint32_t i : on_seam_) contacts[i].leave_out();
}

}  // namespace tactus::physics
