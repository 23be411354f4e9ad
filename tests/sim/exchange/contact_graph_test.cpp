#include "sim/exchange/contact_graph.h"

#include <catch2/catch.hpp>
#include <random>

#include "tests/support/body_index.h"

namespace {

using namespace tactus;
using sim::BodyIndex;
using sim::BodyVector;
using sim::ContactEdge;
using sim::ContactGraph;
using tactus::test::operator""_b;

ContactEdge touch(std::uint32_t a, std::uint32_t b) { return {BodyIndex{a}, BodyIndex{b}, {}, {1, 0, 0}}; }

// Shortest ways by relaxing every edge until nothing changes: slow, and another way to the same answer.
BodyVector<std::uint32_t> hops_by_relaxation(std::uint32_t bodies, const std::vector<ContactEdge>& touches,
                                             BodyIndex from) {
  BodyVector<std::uint32_t> hops(bodies, ContactGraph::kNoPath);
  hops[from] = 0;
  for (bool changed = true; changed;) {
    changed = false;
    for (const ContactEdge& t : touches)
      for (const auto& [p, q] : {std::pair(t.a, t.b), std::pair(t.b, t.a)})
        if (hops[p] != ContactGraph::kNoPath && hops[p] + 1 < hops[q]) {
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
  const auto links = graph.links(3_b);
  REQUIRE(links.size() == 3);
  CHECK((links[0].body == 1_b && links[0].touch == 1));
  CHECK((links[1].body == 0_b && links[1].touch == 2));
  CHECK((links[2].body == 2_b && links[2].touch == 3));
  CHECK(graph.links(0_b).size() == 2);
  CHECK(graph.links(4_b).empty());
}

TEST_CASE("The component of a body is whatever contacts link to it") {
  ContactGraph graph(7, 8);
  graph.build(7, std::vector{touch(0, 1), touch(1, 2), touch(4, 5)});
  CHECK(graph.find_component(0_b) == 3);
  CHECK(graph.hops(0_b) == 0);
  CHECK(graph.hops(2_b) == 2);
  CHECK(graph.hops(4_b) == ContactGraph::kNoPath);
  CHECK(graph.find_component(5_b) == 2);
  CHECK(graph.hops(0_b) == ContactGraph::kNoPath);
  CHECK(graph.find_component(6_b) == 1);
}

TEST_CASE("Seeds count as touching the start") {
  ContactGraph graph(6, 8);
  graph.build(6, std::vector{touch(0, 1), touch(3, 4)});
  CHECK(graph.find_component(0_b, std::vector{3_b}) == 4);
  CHECK(graph.hops(3_b) == 1);
  CHECK(graph.hops(4_b) == 2);
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
    const auto expected = hops_by_relaxation(static_cast<std::uint32_t>(bodies), touches, 0_b);
    const std::uint32_t size = graph.find_component(0_b);
    CHECK(size ==
          bodies - static_cast<std::size_t>(std::count(expected.begin(), expected.end(), ContactGraph::kNoPath)));
    std::uint32_t last = 0;
    for (const BodyIndex body : graph.visited()) {
      REQUIRE(graph.hops(body) == expected[body]);
      CHECK(graph.hops(body) >= last);
      last = graph.hops(body);
    }
  }
}

TEST_CASE("A contact is represented by the mean of its points where the impulses act") {
  const std::vector bodies{physics::make_dynamic_body(0, physics::Shape::sphere(1), 1.0, 0.5, {{10, 0, 0}, {}}),
                           physics::make_dynamic_body(1, physics::Shape::sphere(1), 1.0, 0.5, {{12, 0, 0}, {}})};
  std::vector<physics::Contact> contacts(1);
  physics::Contact& contact = contacts[0];
  contact.slot_a = 0;
  contact.slot_b = 1;
  contact.normal = {1, 0, 0};
  contact.count = 2;
  contact.points[0].from_a = {1, 0, 0};
  contact.points[1].from_a = {1, 4, 0};
  CHECK(sim::contact_edge_of(contacts, bodies, test::all_awake(2)).point == Vec3d{11, 2, 0});
  contact.points[0].total_normal_impulse = 3;
  contact.points[1].total_normal_impulse = 1;
  const ContactEdge weighted = sim::contact_edge_of(contacts, bodies, test::all_awake(2));
  CHECK(weighted.point == Vec3d{11, 1, 0});
  CHECK(weighted.normal == Vec3d{1, 0, 0});

  // Another part of the two bodies touches, and presses harder.
  physics::Contact other = contact;
  other.normal = {0, 0, 1};
  other.points[0] = {};
  other.points[0].from_a = {1, 0, 8};
  other.points[0].total_normal_impulse = 12;
  other.count = 1;
  contacts.push_back(other);
  const ContactEdge both = sim::contact_edge_of(contacts, bodies, test::all_awake(2));
  CHECK(norm(both.point - Vec3d{11, 0.25, 6}) < 1e-12);
  CHECK(both.normal == Vec3d{0, 0, 1});
}
