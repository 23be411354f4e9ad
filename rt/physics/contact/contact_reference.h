// A contact's points, fixed to its two bodies: as long as the bodies have hardly moved against each other since they
// were found, the contact is brought up to date from them instead of being found anew. Neither turns by more than that
// either, so that the normal may stay.
//
// Both bodies carry each point along; the gap has changed by how far they carried it apart along the normal, which
// stays as it was in the world. To first order that is exact; what it neglects is of the order of motion^2 / size.
// What narrow phase did not find was further off than its margin: carried over only while the motion since then plus
// what this step can close fits into that margin, so nothing can touch that is not there.
// Frame: world; anchors in the bodies' frames. Units: m. Thread: [any]; pure. Part of the state: it goes on the tape.
#pragma once

#include "rt/physics/body_frame.h"
#include "rt/physics/collision/motion_bound.h"
#include "rt/physics/contact/contact.h"

namespace tactus::physics {

struct ContactReference {
  static constexpr std::uint32_t kPoints = kMaxManifoldPoints;

  double tolerance{};                             // m: what the surfaces may move, in all; 0: to be found anew
  double moved{};                                 // m, against each other since the points were found, at most
  double margin{};                                // m, with which they were found
  double lever_arm{};                             // m, the larger of the two bodies' radii
  double on_a[3][kPoints]{}, on_b[3][kPoints]{};  // m, body axes, from the centres of A and B
  double separation[kPoints]{};                   // m, when they were found
};

// Which pairs are worth it: two polyhedra. All others are found in less time than it takes.
constexpr bool is_carried_over(const Shape& a, const Shape& b) noexcept {
  const auto is_polyhedron = [](ShapeKind kind) { return kind == ShapeKind::kBox || kind == ShapeKind::kHull; };
  return is_polyhedron(a.kind) && is_polyhedron(b.kind);
}

// What two such bodies may move before their contact is found anew [m]: `most`, but no more than a hundredth of what
// the thinner one is half as thick as. Spread over half of that by the pair's key, so that the contacts of bodies which
// move together do not all end at the same tick.
double tolerance_of(PairKey key, const Shape& a, const Shape& b, double most) noexcept;

// Of the contact that was just found with that margin.
void keep_reference(const Contact& contact, const BodyFrame& a, const BodyFrame& b, double margin, double tolerance,
                    double lever_arm, ContactReference& reference) noexcept;

// Have the bodies moved so little in all, `moved` [m], that the contact may be carried over? `closing` [m]: what this
// step may close.
constexpr bool may_carry_over(const ContactReference& reference, double moved, double closing) noexcept {
  return reference.tolerance > 0.0 && moved <= reference.tolerance && moved + closing <= reference.margin;
}

// Points and separations of the contact as the bodies are now; normal, features and impulses stay. Totals become 0.
void carry_over(const ContactReference& reference, const BodyFrame& a, const BodyFrame& b, Contact& contact) noexcept;

}  // namespace tactus::physics
