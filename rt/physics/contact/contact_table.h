// The contacts of a world from step to step: takes pairs, computes manifolds and carries impulses over.
//
// Per step: add_pair for every pair that may touch (any order), then build: sort by key, narrow phase, and the impulses
// of the same pair and feature in the last step. Points are kept up to the separation that the step may close along the
// contact's normal (motion_bound.h). Two shortcuts save most of the work when little moves. A pair of boxes or hulls
// that was separated is not tested again until its bodies have moved against each other by the gap; that is exact, so
// it never changes a result and is not part of the state. A contact of boxes or hulls whose bodies have hardly moved is
// carried over (contact_reference.h); that is part of the state. Pairs without points do not affect the state, so extra
// pairs do not change the bits. Thread: construction [setup]; the rest [rt], by the owner of the World. Frame: world.
// Units: SI. Bound: `Capacities::pairs` pairs (those with fixed bodies and the lowest keys stay) and
// `Capacities::contacts` contacts (the deepest stay, ties by lower key); what did not fit is counted.
#pragma once

#include <span>

#include "rt/base/bounded_vector.h"
#include "rt/physics/body.h"
#include "rt/physics/capacity.h"
#include "rt/physics/collision/motion_bound.h"
#include "rt/physics/contact/contact.h"
#include "rt/physics/contact/contact_reference.h"
#include "rt/physics/contact/flush_seams.h"
#include "rt/physics/contact/warm_start.h"
#include "rt/physics/executor.h"
#include "rt/physics/shapes/shape_lists.h"
#include "rt/physics/step.h"

namespace tactus::physics {

// The triangles of a patch that are near a body: a range of the step's list of triangles.
struct PatchTriangles {
  std::uint32_t first{0}, count{0};
};

class ContactTable {
 public:
  explicit ContactTable(const Capacities& capacities);  // [setup]

  std::span<const Contact> contacts() const noexcept { return contacts_.span(); }
  std::span<Contact> contacts() noexcept { return contacts_.span(); }
  std::span<const ContactReference> references() const noexcept { return references_.span(); }  // by contact

  // --- pairs of this step
  void clear_pairs() noexcept;
  // `b` is a slot of the fixed bodies if the key has `with_fixed`. The body with the lower id comes first, a fixed one
  // second. For a mesh, one pair for each patch: the key has the patch's id, `b` is the slot of the mesh's body. For a
  // compound, one pair for each part that may touch: the key has its index.
  void add_pair(PairKey key, std::uint32_t a, std::uint32_t b, const PatchTriangles& patch = {}) noexcept;

  // Input of narrow phase, by slot.
  struct Scene {
    std::span<const Body> bodies, fixed_bodies;
    std::span<const BodyFrame> frames, fixed_frames;
    std::span<const MotionBound> motion_bounds;
    ShapeLists shapes{};                              // referred to by the bodies' shapes
    std::span<const std::uint32_t> mesh_triangles{};  // the list of which PatchTriangles are ranges
  };
  // `sub_step` [s] of this step; `impulse_scale`: this sub-step / the sub-step of the stored impulses, exactly 1 if
  // equal. Fills pairs, contacts, points, deepest, dropped and the bits of the report.
  void build(const Scene& scene, const StepSettings& settings, double sub_step, double impulse_scale,
             StepReport& report, const Executor& executor = {}) noexcept;

  // --- impulses from another world, used by the next build, then cleared. False if the list is full.
  bool add_warm_start(const WarmStart& warm_start) noexcept { return warm_starts_.try_push(warm_start); }
  std::span<const WarmStart> warm_starts() const noexcept { return warm_starts_.span(); }

  // Continues a contact of another world. If the pair's contact is along the same axis it gets these impulses
  // (start_impulses.h); else it is dropped, and the next build starts from `given` as with add_warm_start: at a corner
  // two boxes may touch along either of two axes, and each world keeps the one that it has. Bound: linear in
  // contacts.
  bool continue_contact(const WarmStart& given, double sub_step) noexcept;

  // Scales the impulses of contacts whose body A is flagged, by slot.
  void scale_impulses_of(std::span<const std::uint8_t> bodies, double factor) noexcept;

  // --- membership changed: a slot was inserted and those above moved up, or a slot was removed with all its contacts
  void slot_inserted(std::uint32_t slot, bool fixed) noexcept;
  void slot_removed(std::uint32_t slot, bool fixed) noexcept;
  // `to`: the new slot of each moving body, by old slot; kNoSlot if it was removed with all its contacts.
  void slots_moved(std::span<const std::uint32_t> to) noexcept;

  // For restoring: empties the table and exposes its storage. There must be as many references as contacts.
  void clear() noexcept;
  BoundedVector<Contact>& stored_contacts() noexcept { return contacts_; }
  BoundedVector<ContactReference>& stored_references() noexcept { return references_; }
  BoundedVector<WarmStart>& stored_warm_starts() noexcept { return warm_starts_; }

 private:
  struct Pair {
    PairKey key;
    std::uint32_t a{0}, b{0};
    PatchTriangles patch;
    double gap{}, lever_arm{};  // m: gap and lever arm of a manifold without points, the gap less the relative motion
                                // since; 0: unknown
    AxisCache apart{};          // of the same manifold
  };
  // A pair that has a contact or may get one: either carried over or searched.
  struct Visit {
    std::uint32_t pair;
    std::uint32_t old;     // first contact of the last step whose key is not lower
    std::uint32_t search;  // kCarryOver, or index of the search
    double moved;          // m, if carried over: see ContactReference
  };
  static constexpr std::uint32_t kCarryOver = ~0u;
  struct Search {
    std::uint32_t pair;
    bool known;              // the last step had a contact of the pair
    const WarmStart* given;  // null: none
    ManifoldQuery query;
    AxisCache axis_cache;
  };
  // Input of a build and its positions in the lists that it merges, all sorted by key.
  struct Walk;

  void sort_pairs() noexcept;
  void sort_warm_starts() noexcept;
  void visit(Walk& walk, std::uint32_t index) noexcept;
  // The two bodies of a pair, and which part of each is meant.
  struct Sides {
    const Body &a, &b;
    std::uint32_t part_a, part_b;
    const Shape &shape_a, &shape_b;  // of the parts
  };
  Sides sides_of(const Scene& scene, const Pair& pair) const noexcept;
  std::uint32_t comparisons_in(const Scene& scene, const Search& search) const noexcept;
  Manifold compare(const Scene& scene, Search& search) const noexcept;
  void compare_boxes(const Scene& scene, std::span<const std::uint32_t> searches) noexcept;
  void search(const Scene& scene, std::uint32_t first, std::uint32_t end) noexcept;
  void keep(Walk& walk, const Visit& visit) noexcept;
  void take_found(Walk& walk, const Visit& visit, const Search& search, Manifold& manifold) noexcept;
  Contact* place(Walk& walk) noexcept;
  void keep_deepest(StepReport& report) noexcept;

  BoundedVector<Pair> pairs_, last_pairs_;
  bool pairs_are_heap_{false};
  std::uint32_t pairs_dropped_{0};
  BoundedVector<Visit> visits_;                                   // of the present block of pairs
  BoundedVector<Search> searches_;                                // same
  BoundedVector<Manifold> manifolds_;                             // by search
  BoundedVector<Contact> contacts_, last_;                        // by key
  BoundedVector<ContactReference> references_, last_references_;  // of contacts_, of last_
  BoundedVector<Contact> beyond_;                                 // contacts beyond the capacity, by key
  BoundedVector<std::uint32_t> order_;                            // of contacts_ and beyond_, by depth
  BoundedVector<WarmStart> warm_starts_;                          // in order of arrival
  BoundedVector<std::uint32_t> warm_start_order_;                 // by key, then by arrival
  FlushSeams seams_;
};

[[gnu::always_inline]] inline ContactTable::Sides ContactTable::sides_of(const Scene& scene,
                                                                         const Pair& pair) const noexcept {
  const Body& a = scene.bodies[pair.a];
  const Body& b = pair.key.with_fixed() ? scene.fixed_bodies[pair.b] : scene.bodies[pair.b];
  const std::uint32_t part_a = pair.key.part_of(a.id), part_b = pair.key.part_of(b.id);  // of a patch: 0
  const Compounds compounds = scene.shapes.compounds;
  return {.a = a,
          .b = b,
          .part_a = part_a,
          .part_b = part_b,
          .shape_a = part_shape(a.shape, part_a, compounds),
          .shape_b = part_shape(b.shape, part_b, compounds)};
}

}  // namespace tactus::physics
