// The paper's graph of contacts between moving bodies, as compressed adjacency lists.
//
// One edge per touching pair, with one representative contact: the impulse-weighted mean of its points, and its normal.
// A joint is an edge too. Static geometry is not a node.
// Thread: the global world's; construction [setup], build and find_component never allocate. Frame: world. Units: m.
// Bound: bodies and edges as given at construction; edges beyond are left out and counted by the caller. Work: build is
// linear in bodies + edges, find_component in the part that it visits. Source: the paper, section 2, equation 1.
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
  bool joined{false};  // by a joint: if one body is a member, the other should be too
};

// The pair's representative contact: mean of its points, weighted by their normal impulses over the step (unweighted if
// all are 0). `bodies` are the world's, by slot; points move with body A.
ContactEdge contact_edge_of(const physics::Contact& contact, std::span<const physics::Body> bodies) noexcept;

class ContactGraph {
 public:
  static constexpr std::uint32_t kUnreached = 0xffffffffu;

  struct Link {
    std::uint32_t body{0};   // slot of the other body
    std::uint32_t touch{0};  // index into touches()
  };

  ContactGraph(std::uint32_t max_bodies, std::uint32_t max_touches);

  // Replaces the graph; copies `touches`. The links of a body are in the order of `touches`.
  void build(std::uint32_t bodies, std::span<const ContactEdge> touches) noexcept;

  std::span<const Link> links(std::uint32_t slot) const noexcept;
  std::span<const ContactEdge> touches() const noexcept { return {touches_.data(), touch_count_}; }
  std::uint32_t bodies() const noexcept { return body_count_; }

  // Finds the connected component of `from`, breadth first: visited() has its slots in the order of hops, `from` first.
  // `seeds` are treated as touching `from`. Returns the component's size.
  std::uint32_t find_component(std::uint32_t from, std::span<const std::uint32_t> seeds = {}) noexcept;
  std::span<const std::uint32_t> visited() const noexcept { return {queue_.data(), visited_count_}; }
  // Edges on the shortest path from `from` of the last find_component to this body; kUnreached if there is no path.
  std::uint32_t hops(std::uint32_t slot) const noexcept { return hops_[slot]; }

 private:
  void visit(std::uint32_t slot, std::uint32_t hops) noexcept;

  std::vector<ContactEdge> touches_;
  std::vector<Link> links_;
  std::vector<std::uint32_t> first_;  // by slot: its first link; bodies + 1 entries
  std::vector<std::uint32_t> hops_, queue_;
  std::uint32_t body_count_{0}, touch_count_{0}, visited_count_{0};
};

}  // namespace tactus::sim
