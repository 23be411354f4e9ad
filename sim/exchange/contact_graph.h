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
#include "sim/body_index.h"

namespace tactus::sim {

// Two moving bodies that touch or that a joint connects, by body index.
struct ContactEdge {
  BodyIndex a{}, b{};
  Vec3d point;         // m, world
  Vec3d normal;        // unit, world, from a to b
  bool joined{false};  // by a joint: if one body is a member, the other should be too
};

// The pair's representative contact: mean of its points, weighted by their normal impulses over the step (unweighted if
// all are 0), with the normal of the contact with the largest normal impulse. `contacts`: of one pair of bodies, at
// least one. `bodies`: of the contacts' world, by slot; `awake`: the body index of each slot. The points are fixed to
// body A.
ContactEdge contact_edge_of(std::span<const physics::Contact> contacts, std::span<const physics::Body> bodies,
                            std::span<const BodyIndex> awake) noexcept;

class ContactGraph {
 public:
  static constexpr std::uint32_t kNoPath = 0xffffffffu;

  struct Link {
    BodyIndex body{};        // the other body
    std::uint32_t touch{0};  // index into touches()
  };

  ContactGraph(std::uint32_t max_bodies, std::uint32_t max_touches);

  // Replaces the graph; copies `touches`. The links of a body are in the order of `touches`.
  void build(std::uint32_t bodies, std::span<const ContactEdge> touches) noexcept;

  std::span<const Link> links(BodyIndex body) const noexcept;
  std::span<const ContactEdge> touches() const noexcept { return {touches_.data(), touch_count_}; }
  std::uint32_t bodies() const noexcept { return body_count_; }

  // Finds the connected component of `from`, breadth first: visited() has its bodies in the order of hops, `from`
  // first. `seeds` are treated as touching `from`. Returns the component's size.
  std::uint32_t find_component(BodyIndex from, std::span<const BodyIndex> seeds = {}) noexcept;
  std::span<const BodyIndex> visited() const noexcept { return {queue_.data(), visited_count_}; }
  // Edges on the shortest path from `from` of the last find_component to this body; kNoPath if there is no path.
  std::uint32_t hops(BodyIndex body) const noexcept { return hops_[body]; }

 private:
  void visit(BodyIndex body, std::uint32_t hops) noexcept;

  std::vector<ContactEdge> touches_;
  std::vector<Link> links_;
  std::vector<std::uint32_t> first_;  // by number_of(body): its first link; bodies + 1 entries
  BodyVector<std::uint32_t> hops_;
  std::vector<BodyIndex> queue_;
  std::uint32_t body_count_{0}, touch_count_{0}, visited_count_{0};
};

}  // namespace tactus::sim
