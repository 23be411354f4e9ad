// Finds the contacts that a body has with the edges of flush seams. The solver leaves them out.
//
// A body that slides from one body onto the next at the same height is lower than the next one's face, by its overlap
// with the first. Its shallowest overlap there is with the next one's side, and a contact with that side would stop it.
// A contact of S, which moves, and T with the normal n lies on a seam if three things hold.
// 1. T has a flat face with the normal m across n, |m . n| < 0.5, that bounds S from below within t: with d the offset
// of the face, |min over S of m . x - d| <= t. So a motion of t along m takes S past T.
// 2. All points of the contact are within 2 kFlush of that face's plane: they are near its edge.
// 3. A third body supports S: it has a contact with S, of an overlap or gap of at most t, whose normal u towards S is
// parallel to the face's, m . u > 0.999.
// t is kFlush, or 1 % of the thinner of S and T if that is less. What leans against an edge, or stands before a kerb,
// keeps its contact, since it reaches below T's face. Flat faces are those of boxes, hulls and parts of compounds, the
// ends of cylinders, the base of a cone and the patches of meshes. Within one compound or mesh see redundant_points.h
// and mesh_region.h.
// Frame: world. Units: SI. Thread: construction [setup]; mark() [rt]. Bound: linear in the contacts, times the faces of
// T and the vertices of S; for those that lie on a seam also in the contacts of S.
#pragma once

#include <span>

#include "rt/base/bounded_vector.h"
#include "rt/physics/body.h"
#include "rt/physics/capacity.h"
#include "rt/physics/contact/contact.h"
#include "rt/physics/contact/redundant_points.h"

namespace tactus::physics {

class FlushSeams {
 public:
  explicit FlushSeams(const Capacities& capacities);

  // Sets `redundant` of all points of the contacts on seams, and clears their impulses. Where a contact cannot come to
  // lie on one while it is carried over, by bodies that move against each other by `carried` [m], clears may_be_flush,
  // and looks at it again when it was searched again.
  void mark(const TouchingBodies& bodies, double carried, std::span<Contact> contacts) noexcept;

 private:
  void list_contacts_of(std::size_t bodies, std::span<const Contact> contacts) noexcept;
  bool passes_over(const TouchingBodies& bodies, std::span<const Contact> contacts, std::uint32_t contact,
                   bool b_over_a) const noexcept;

  BoundedVector<std::uint32_t> on_seam_;         // contacts
  BoundedVector<std::uint32_t> first_, listed_;  // of slot s the contacts listed_[first_[s]] to listed_[first_[s + 1]]
};

}  // namespace tactus::physics
