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
#include "rt/physics/collision/reach.h"
#include "rt/physics/contact/contact.h"

namespace tactus::physics {

template <class T>
struct ContactReference {
  static constexpr std::uint32_t kPoints = kMaxManifoldPoints;

  T tolerance{};                             // m: what the surfaces may move, in all; 0: to be found anew
  T moved{};                                 // m, against each other since the points were found, at most
  T margin{};                                // m, with which they were found
  T lever{};                                 // m, the larger of the two bodies' radii
  T on_a[3][kPoints]{}, on_b[3][kPoints]{};  // m, body axes, from the centres of A and B
  T separation[kPoints]{};                   // m, when they were found
};

// Which pairs are worth it: two polyhedra. All others are found in less time than it takes.
template <class T>
constexpr bool is_carried_over(const Shape<T>& a, const Shape<T>& b) noexcept {
  const auto is_polyhedron = [](ShapeKind kind) { return kind == ShapeKind::kBox || kind == ShapeKind::kHull; };
  return is_polyhedron(a.kind) && is_polyhedron(b.kind);
}

// What two such bodies may move before their contact is found anew [m]: `most`, but no more than a hundredth of what
// the thinner one is half as thick as. Spread over half of that by the pair's key, so that the contacts of bodies which
// move together do not all end at the same tick.
template <class T>
T tolerance_of(PairKey key, const Shape<T>& a, const Shape<T>& b, T most) noexcept;

// Of the contact that was just found with that margin.
template <class T>
void keep_reference(const Contact<T>& contact, const BodyFrame<T>& a, const BodyFrame<T>& b, T margin, T tolerance,
                    T lever, ContactReference<T>& reference) noexcept;

// Have the bodies moved so little in all, `moved` [m], that the contact may be carried over? `closing` [m]: what this
// step may close.
template <class T>
constexpr bool may_carry_over(const ContactReference<T>& reference, T moved, T closing) noexcept {
  return reference.tolerance > T(0) && moved <= reference.tolerance && moved + closing <= reference.margin;
}

// Points and separations of the contact as the bodies are now; normal, features and impulses stay. Totals become 0.
template <class T>
void carry_over(const ContactReference<T>& reference, const BodyFrame<T>& a, const BodyFrame<T>& b,
                Contact<T>& contact) noexcept;

}  // namespace tactus::physics
