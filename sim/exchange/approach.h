// Bodies that are about to touch a member: links of the contact graph before there is a contact.
//
// A body that a member hits is known to the sub-world one cycle after the global step has found the contact; a domino
// has sunk into the next one by then. So a pair of a member and another body counts as touching where its surfaces
// close, at the speed that they have now, within `horizon_s`: two cycles, until the next choice of members but one.
// Thread: the global world's; construction [setup], the rest never allocates. Frame: world. Units: SI. Work: linear in
// bodies, and in members times the bodies in reach of any. Bound: as many touches as there is room for.
// Source: speculative contacts (Catto 2013); the study of couplings, section 4.7.
#pragma once

#include <span>
#include <vector>

#include "sim/exchange/contact_graph.h"

namespace tactus::sim {

class Approach {
 public:
  explicit Approach(std::uint32_t max_bodies);

  // Appends to `touches`, by slot, up to its capacity. `members` by slot.
  void find(const physics::World& world, physics::Hulls hulls, std::span<const std::uint8_t> members, double horizon_s,
            std::vector<ContactEdge>& touches) noexcept;

 private:
  struct Moving {
    std::uint32_t slot;
    double reach_m;     // how far a point of its surface gets within the horizon
    physics::Aabb box;  // that it reaches
  };

  std::vector<Moving> members_, others_;
};

}  // namespace tactus::sim
