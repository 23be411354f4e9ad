#include "sim/exchange/contact_graph.h"

#include <catch2/catch.hpp>
#include <random>

namespace {

using namespace tactus;
using sim::ContactEdge;
using sim::ContactGraph;

ContactEdge touch(std::uint32_t a, std::uint32_t b) { return {a, b, {}, {1, 0, 0}}; }

// Shortest ways by relaxing every edge until nothing changes: slow, and another way to the same answer.
std::vector<std::uint32_t> hops_by_relaxation(std::uint32_t bodies, const std::vector<ContactEdge>& touches,
                                              std::uint32_t from) {
  std::vector<std::uint32_t> hops(bodies, ContactGraph::kUnreached);
  hops[from] = 0;
  for (bool changed = true; changed;) {
    changed = false;
    for (const ContactEdge& t : touches)
      for (const auto& [p, q] : {std::pair(t.a, t.b), std::pair(t.b, t.a)})
        if (hops[p] != ContactGraph::kUnreached && hops[p] + 1 < hops[q]) {
          hops[q] = hops[p] + 1;
          changed = true;
        }
  }
  return hops;
}

}  // namespace

TEST_CASE("Links of a body are its contacts, in the order given, from both sides") {
  ContactGraph graph(5, 8);
  graph.build(5, std::vector{touch(0, 1), touch(1, 3), touch(0, 3), touch(2, 3)});
  const auto links = graph.links(3);
  REQUIRE(links.size() == 3);
  CHECK((links[0].body == 1 && links[0].touch == 1));
  CHECK((links[1].body == 0 && links[1].touch == 2));
  CHECK((links[2].body == 2 && links[2].touch == 3));
  CHECK(graph.links(0).size() == 2);
  CHECK(graph.links(4).empty());
}

TEST_CASE("The component of a body is whatever contacts link to it") {
  ContactGraph graph(7, 8);
  graph.build(7, std::vector{touch(0, 1), touch(1, 2), touch(4, 5)});
  CHECK(graph.find_component(0) == 3);
  CHECK(graph.hops(0) == 0);
  CHECK(graph.hops(2) == 2);
  CHECK(graph.hops(4) == ContactGraph::kUnreached);
  CHECK(graph.find_component(5) == 2);
  CHECK(graph.hops(0) == ContactGraph::kUnreached);
  CHECK(graph.find_component(6) == 1);
}

TEST_CASE("Seeds count as touching the start") {
  ContactGraph graph(6, 8);
  graph.build(6, std::vector{touch(0, 1), touch(3, 4)});
  CHECK(graph.find_component(0, std::vector<std::uint32_t>{3}) == 4);
  CHECK(graph.hops(3) == 1);
  CHECK(graph.hops(4) == 2);
}

TEST_CASE("Hops are shortest ways on any graph, and visiting is in their order") {
  std::mt19937 random(3);
  ContactGraph graph(60, 120);
  for (int round = 0; round < 50; ++round) {
    const auto bodies = 2 + random() % 59;
    std::vector<ContactEdge> touches;
    for (unsigned i = 0; i < random() % 90; ++i) {
      const auto a = static_cast<std::uint32_t>(random() % bodies), b = static_cast<std::uint32_t>(random() % bodies);
      if (a != b) touches.push_back(touch(std::min(a, b), std::max(a, b)));
    }
    graph.build(static_cast<std::uint32_t>(bodies), touches);
    const auto expected = hops_by_relaxation(static_cast<std::uint32_t>(bodies), touches, 0);
    const std::uint32_t size = graph.find_component(0);
    CHECK(size ==
          bodies - static_cast<std::size_t>(std::count(expected.begin(), expected.end(), ContactGraph::kUnreached)));
    std::uint32_t last = 0;
    for (const std::uint32_t slot : graph.visited()) {
      REQUIRE(graph.hops(slot) == expected[slot]);
      CHECK(graph.hops(slot) >= last);
      last = graph.hops(slot);
    }
  }
}

TEST_CASE("A contact is represented by the mean of its points where the impulses act") {
  const std::vector bodies{physics::make_dynamic_body(0, physics::Shape::sphere(1), 1.0, 0.5, {{10, 0, 0}, {}}),
                           physics::make_dynamic_body(1, physics::Shape::sphere(1), 1.0, 0.5, {{12, 0, 0}, {}})};
  physics::Contact contact;
  contact.slot_a = 0;
  contact.slot_b = 1;
  contact.normal = {1, 0, 0};
  contact.count = 2;
  contact.points[0].from_a = {1, 0, 0};
  contact.points[1].from_a = {1, 4, 0};
  CHECK(sim::contact_edge_of(contact, bodies).point == Vec3d{11, 2, 0});
  contact.points[0].total_normal_impulse = 3;
  contact.points[1].total_normal_impulse = 1;
  const ContactEdge weighted = sim::contact_edge_of(contact, bodies);
  CHECK(weighted.point == Vec3d{11, 1, 0});
  CHECK(weighted.normal == Vec3d{1, 0, 0});
}
