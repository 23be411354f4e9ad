// Who touches whom: the paper's graph of contacts between moving bodies, as compressed adjacency.
//
// One edge per touching pair, with one representative contact: the point where its impulses' mean acts, and its
// normal. A joint is an edge too. Static geometry is no node. Thread: the global world's; construction [setup], build
// and component never allocate. Frame: world. Units: m. Bound: bodies and edges as given at construction; edges beyond
// are left out and counted by the caller. Work: build is linear in bodies + edges, component in the part that it
// visits. Source: the paper, section 2, equation 1.
#pragma once

#include <span>
#include <vector>

#include "rt/physics/world.h"

namespace tactus::sim {

// Two dynamic bodies that touch, by slot.
struct ContactEdge {
  std::uint32_t a{0}, b{0};
  Vec3d point;         // m, world
  Vec3d normal;        // unit, world, from a to b
  bool joined{false};  // by a joint: where the one is a member, the other should be
};

// The pair's representative: mean of its points, weighted by the impulse they carried over the step (evenly where none
// carried any). `bodies` are the world's, by slot; points move with body A.
ContactEdge contact_edge_of(const physics::Contact& contact, std::span<const physics::Body> bodies) noexcept;

class ContactGraph {
 public:
  static constexpr std::uint32_t kUnreached = 0xffffffffu;

  struct Link {
    std::uint32_t body{0};   // slot of the other body
    std::uint32_t touch{0};  // index into touches()
  };

  ContactGraph(std::uint32_t max_bodies, std::uint32_t max_touches);

  // Replaces the graph. Links of a body come in the order of `touches`, which is kept.
  void build(std::uint32_t bodies, std::span<const ContactEdge> touches) noexcept;

  std::span<const Link> links(std::uint32_t slot) const noexcept;
  std::span<const ContactEdge> touches() const noexcept { return {touches_.data(), touch_count_}; }
  std::uint32_t bodies() const noexcept { return body_count_; }

  // The connected component of `from`, by breadth first: visited() holds its slots in the order of hops, `from` first.
  // `seeds` count as if they touched `from`. Returns its size.
  std::uint32_t find_component(std::uint32_t from, std::span<const std::uint32_t> seeds = {}) noexcept;
  std::span<const std::uint32_t> visited() const noexcept { return {queue_.data(), visited_count_}; }
  // Contacts between `from` of the last find_component and this body; kUnreached where there is no way.
  std::uint32_t hops(std::uint32_t slot) const noexcept { return hops_[slot]; }

 private:
  void visit(std::uint32_t slot, std::uint32_t hops) noexcept;

  std::vector<ContactEdge> touches_;
  std::vector<Link> links_;
  std::vector<std::uint32_t> first_;  // by slot: its first link; one more than bodies
  std::vector<std::uint32_t> hops_, queue_;
  std::uint32_t body_count_{0}, touch_count_{0}, visited_count_{0};
};

}  // namespace tactus::sim
