// Predicts contacts between members and other bodies before there is one.
//
// The sub-world receives what a member hits one cycle after the global step has found the contact. By then a domino has
// penetrated the next one. So a member and another body approach each other if, at their present velocities, their
// surfaces meet within `horizon_s`: two cycles, until the next choice of members but one. Such a pair is an edge of the
// contact graph, and a contact of the border if the other body does not become a member.
//
// Thread: the global world's; construction [setup], the rest never allocates. Frame: world. Units: SI. Work: linear in
// bodies, and in members times the bodies in reach of any. Bound: kMaxApproaches pairs; further ones are left out.
// Source: speculative contacts (Catto 2013); sim/exchange/README.md, "Bodies that approach".
#pragma once

#include <span>
#include <vector>

#include "rt/physics/slot_index.h"
#include "rt/physics/world.h"

namespace tactus::sim {

inline constexpr std::uint32_t kMaxApproaches = 1024;

// A member and another body that will meet, by one part of each, and the points that will: their separation is less
// than they close.
struct Approaching {
  physics::SlotIndex a{}, b{};         // a < b
  std::uint32_t part_a{0}, part_b{0};  // parts of the two bodies; the pairs of parts of two bodies are consecutive
  physics::Manifold manifold;
  double round_a{0}, round_b{0};  // m: as in physics::Contact
};

class Approach {
 public:
  explicit Approach(std::uint32_t max_bodies);

  // `members`, by slot of the world: 1 for a member. Parts that touch are left out. Valid until the next call.
  std::span<const Approaching> find(const physics::World& world, std::span<const std::uint8_t> members,
                                    double horizon_s) noexcept;

 private:
  struct Moving {
    physics::SlotIndex slot;
    double reach_m;     // bound on a surface point's motion within the horizon
    physics::Aabb box;  // the body's bounds, grown by reach_m
  };

  void compare(const physics::World& world, const Moving& a, const Moving& b, double horizon_s) noexcept;

  std::vector<Moving> members_, others_;
  std::vector<Approaching> found_;
};

}  // namespace tactus::sim
