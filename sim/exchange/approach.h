// Predicts contacts between members and other bodies: edges of the contact graph before there is a contact.
//
// The sub-world receives a body that a member hits one cycle after the global step has found the contact. By then a
// domino has penetrated the next one. So a member and another body count as touching if, at their present velocities,
// their surfaces meet within `horizon_s`: two cycles, until the next choice of members but one.
// Thread: the global world's; construction [setup], the rest never allocates. Frame: world. Units: SI. Work: linear in
// bodies, and in members times the bodies in reach of any. Bound: the capacity of `touches`; further pairs are left
// out. Source: speculative contacts (Catto 2013); the study of couplings, section 4.7.
#pragma once

#include <span>
#include <vector>

#include "sim/exchange/contact_graph.h"

namespace tactus::sim {

class Approach {
 public:
  explicit Approach(std::uint32_t max_bodies);

  // Appends edges to `touches`, up to its capacity. By slot of the world: `members`, 1 for a member; `awake`.
  void find(const physics::World& world, physics::Hulls hulls, std::span<const std::uint8_t> members,
            std::span<const BodyIndex> awake, double horizon_s, std::vector<ContactEdge>& touches) noexcept;

 private:
  struct Moving {
    std::uint32_t slot;
    double reach_m;     // bound on a surface point's motion within the horizon
    physics::Aabb box;  // the body's bounds, grown by reach_m
  };

  std::vector<Moving> members_, others_;
};

}  // namespace tactus::sim
