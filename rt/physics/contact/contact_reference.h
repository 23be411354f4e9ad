// A contact's points as anchors in its two bodies. While the bodies have hardly moved against each other, the contact
// is updated from the anchors instead of by narrow phase. Their rotation is bounded by the same tolerance, so the
// normal is kept.
//
// Each body carries its anchor along; the gap changes by the distance between the two anchors along the normal, which
// stays fixed in the world. That is exact to first order; the error is of the order of motion^2 / size. Points that
// narrow phase did not find were further apart than its margin. The contact is carried over only while the motion since
// then plus what this step can close is within that margin, so no contact point can be missed.
// Frame: world; anchors in the bodies' frames. Units: m. Thread: [any]; pure. Part of the state: goes on the tape.
#pragma once

#include "rt/physics/body_frame.h"
#include "rt/physics/collision/motion_bound.h"
#include "rt/physics/contact/contact.h"

namespace tactus::physics {

struct ContactReference {
  static constexpr std::uint32_t kPoints = kMaxManifoldPoints;

  double tolerance{};  // m: how far the surfaces may move in all; 0: not usable, the manifold must be recomputed
  double moved{};      // m: upper bound of the relative motion since the points were found
  double margin{};     // m: margin with which they were found
  double lever_arm{};  // m, the larger of the two bodies' radii
  double on_a[3][kPoints]{}, on_b[3][kPoints]{};  // m, body axes, from the centres of A and B
  double separation[kPoints]{};                   // m, when they were found
};

// True for a pair of polyhedra; for all other pairs narrow phase is faster than carrying over.
constexpr bool is_carried_over(const Shape& a, const Shape& b) noexcept {
  const auto is_polyhedron = [](ShapeKind kind) { return kind == ShapeKind::kBox || kind == ShapeKind::kHull; };
  return is_polyhedron(a.kind) && is_polyhedron(b.kind);
}

// Relative motion allowed before the manifold is recomputed [m]: min(most, 1 % of the thinner body's half thickness),
// scaled by a factor in (0.5, 1] hashed from the pair's key, so that manifolds of bodies that move together do not
// expire in the same tick.
double tolerance_of(PairKey key, const Shape& a, const Shape& b, double most) noexcept;

// Fills the anchors and separations from a contact that narrow phase just found.
void store_anchors(const Contact& contact, const BodyFrame& a, const BodyFrame& b,
                   ContactReference& reference) noexcept;

// True if the contact may be carried over. `moved` [m]: bound of the relative motion since the points were found;
// `closing` [m]: bound of what this step closes.
constexpr bool may_carry_over(const ContactReference& reference, double moved, double closing) noexcept {
  return reference.tolerance > 0.0 && moved <= reference.tolerance && moved + closing <= reference.margin;
}

// Updates the contact's points and separations to the bodies' present poses; normal, features and impulses stay, totals
// become 0.
void carry_over(const ContactReference& reference, const BodyFrame& a, const BodyFrame& b, Contact& contact) noexcept;

}  // namespace tactus::physics
