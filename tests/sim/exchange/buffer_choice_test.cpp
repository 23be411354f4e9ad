#include "sim/exchange/buffer_choice.h"

#include <catch2/catch.hpp>

#include "tests/support/body_index.h"

namespace {

using namespace tactus;
using namespace tactus::sim;
using tactus::test::operator""_b;
using tactus::test::operator""_slot;

// Body 0 is the proxy. The first `members` bodies are members: no other is free.
struct Bench {
  std::vector<physics::Body> bodies;
  std::vector<ContactEdge> touches;
  std::vector<physics::Contact> contacts;
  std::vector<haptics::OutsideBody> outside;
  std::uint32_t members;

  Bench(const std::vector<double>& masses, std::uint32_t how_many) : members(how_many) {
    for (std::size_t i = 0; i < masses.size(); ++i)
      bodies.push_back(physics::make_dynamic_body(static_cast<BodyId>(i), physics::Shape::sphere(0.1), masses[i], 0.5,
                                                  {{10.0 * double(i), 0, 0}, {}}));
  }
  void link(std::uint32_t a, std::uint32_t b, bool joined = false) {
    touches.push_back({BodyIndex{a}, BodyIndex{b}, {5.0 * (a + b), 0, 0}, {1, 0, 0}, joined});
  }
  // It presses on static geometry.
  void ground(physics::SlotIndex slot) {
    physics::Contact contact;
    contact.slot_a = number_of(slot);
    contact.b_fixed = true;
    contact.count = 1;
    contact.points[0].total_normal_impulse = 1;
    contacts.push_back(contact);
  }
  // The ghost of an outside body, with that inverse mass.
  void ghost(BodyIndex of, double w) {
    const physics::Body& own = bodies[number_of(of)];
    haptics::OutsideBody body;
    body.id = own.id;
    body.centre = own.motion.pose.position;
    body.admittance.linear = {w, w, w, 0, 0, 0};
    outside.push_back(body);
  }
  // The buffer, ascending; `added`: of these for an uneven group alone.
  std::vector<std::uint32_t> choose(std::uint32_t added) {
    const auto count = static_cast<std::uint32_t>(bodies.size());
    ContactGraph graph(count, 100);
    ExtractionOptions options;
    options.cap = members;
    const BodySpan<const physics::Body> all(bodies);
    Extraction extraction(options, {}, all, 0_b, 100);
    graph.build(count, touches);
    BodyVector<std::uint8_t> free(count, 0);
    for (const BodyIndex body : BodyIndices(members)) free[body] = 1;
    const auto chosen = extraction.choose(all, graph, bodies[0].motion.pose, members, free);
    REQUIRE(chosen.size() == members);
    for (std::uint32_t i = 0; i < members; ++i) REQUIRE(chosen[i] == BodyIndex{i});
    BufferChoice choice(count);
    BodyVector<std::uint8_t> flags(count, 1);
    const auto awake = test::all_awake(count);
    CHECK(choice.choose(all, extraction, graph, 0_b, {contacts, awake, outside}, flags) == added);
    std::vector<std::uint32_t> result;
    for (const BodyIndex body : flags.indices())
      if (flags[body] != 0) result.push_back(number_of(body));
    return result;
  }
};

using Chosen = std::vector<std::uint32_t>;  // numbers of bodies

}  // namespace

TEST_CASE("The buffer is who touches an outside body where masses are even, and never the proxy") {
  Bench b({0.01, 1, 1.5, 2, 1}, 4);
  b.link(0, 1);
  b.link(1, 2);
  b.link(2, 3);
  b.link(3, 4);
  b.link(0, 4);
  CHECK(b.choose(0) == Chosen{3});
}

TEST_CASE("A group at the border whose masses are uneven is the buffer as a whole") {
  const double heavy = GENERATE(2.1, 10.0, 1000.0);
  const bool joined = GENERATE(false, true);
  Bench b({0.01, heavy, 1, 1, 1}, 4);
  b.link(0, 1);
  b.link(1, 2, joined);
  b.link(2, 3, joined);
  b.link(3, 4);
  CHECK(b.choose(2) == Chosen{1, 2, 3});
}

TEST_CASE("A group that touches nothing outside stays the sub-world's, however uneven") {
  Bench b({0.01, 1000, 1, 1, 1, 1}, 5);
  b.link(0, 1);
  b.link(1, 2);
  b.link(0, 3);
  b.link(3, 4);
  b.link(4, 5);
  CHECK(b.choose(0) == Chosen{4});
}

TEST_CASE("The proxy links no groups: it touches each of them, and is lighter than any") {
  Bench b({0.01, 300, 1, 1, 1, 1, 1}, 5);
  b.link(0, 1);
  b.link(1, 2);
  b.link(2, 5);  // uneven
  b.link(0, 3);
  b.link(3, 4);
  b.link(4, 6);  // even
  CHECK(b.choose(1) == Chosen{1, 2, 4});
}

TEST_CASE("The mass of a member at the end of a group does not count where its sweep converges") {
  // 1: 2 kg; 2: 0.3 kg on the ground below it; 3: 0.2 kg upon it, with the outside body 4.
  Bench b({0.01, 2, 0.3, 0.2, 0.2}, 4);
  b.link(0, 1);
  b.link(1, 2);
  b.link(1, 3);
  b.link(3, 4);
  b.ground(2_slot);
  const bool at_edge = GENERATE(false, true), under_light = GENERATE(false, true);
  // A sphere's inertia is 0.4 m r^2: 0.11 m aside the 2 kg weigh 0.5 kg, and the cube's ghost 0.2.
  if (at_edge) b.touches[1].point.y = b.touches[2].point.y = 0.11;
  b.ghost(4_b, under_light ? 1 / 0.2 : 0);
  for (std::uint32_t k = 2; at_edge && k <= 3; ++k) b.bodies[k].motion.pose.position.y = 0.11;
  const bool even = at_edge && under_light;
  CHECK(b.choose(even ? 0 : 2) == (even ? Chosen{3} : Chosen{1, 2, 3}));
}

TEST_CASE("Light bodies in series count, whatever holds the last one") {
  Bench b({0.01, 10, 1, 1, 1}, 4);
  b.link(0, 1);
  b.link(1, 2);
  b.link(2, 3);
  b.link(3, 4);
  b.ghost(4_b, 1e3);
  CHECK(b.choose(2) == Chosen{1, 2, 3});
}

TEST_CASE("A joint holds as firmly as the ground") {
  const bool joined = GENERATE(false, true);
  Bench b({0.01, 3, 1, 1}, 3);
  b.link(0, 1);
  b.link(1, 2);
  b.link(2, 3, joined);
  b.ghost(3_b, 1);
  CHECK(b.choose(joined ? 1 : 0) == (joined ? Chosen{1, 2} : Chosen{2}));
}
