#include "sim/exchange/extraction.h"

#include <catch2/catch.hpp>
#include <memory>
#include <random>
#include <set>

#include "tests/support/body_index.h"

namespace {

using namespace tactus;
using namespace tactus::sim;
using tactus::test::operator""_b;
using Bodies = std::vector<physics::Body>;
using Chosen = std::vector<std::uint32_t>;  // numbers of bodies

physics::Body ball(std::size_t id, const Vec3d& where, double mass = 1) {
  return physics::make_dynamic_body(static_cast<BodyId>(id), physics::Shape::sphere(0.1), mass, 0.5, {where, {}});
}

Chosen numbers_of(std::span<const BodyIndex> members) {
  Chosen numbers;
  for (const BodyIndex member : members) numbers.push_back(number_of(member));
  return numbers;
}

// A world of hand-made contacts: body 0 is the proxy, at the origin; the others are far from the cube unless placed.
struct Bench {
  Bodies bodies;
  std::vector<ContactEdge> touches;
  ExtractionOptions options;
  ReachSettings reach;
  std::unique_ptr<ContactGraph> graph;
  std::unique_ptr<Extraction> extraction;

  explicit Bench(std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) bodies.push_back(ball(i, {i == 0 ? 0.0 : 10.0 + 0.2 * double(i), 0, 0}));
  }
  void link(std::uint32_t a, std::uint32_t b) {
    const Vec3d middle = 0.5 * (bodies[a].motion.pose.position + bodies[b].motion.pose.position);
    touches.push_back({BodyIndex{std::min(a, b)}, BodyIndex{std::max(a, b)}, middle, {1, 0, 0}});
  }
  // 0 - 1 - 2 - ... : influence halves from body to body.
  void link_row() {
    for (std::uint32_t a = 0; a + 1 < bodies.size(); ++a) link(a, a + 1);
  }
  Chosen choose(std::uint32_t budget = haptics::kMaxMembers) {
    if (!extraction) {
      const auto count = static_cast<std::uint32_t>(bodies.size());
      graph = std::make_unique<ContactGraph>(count, 4000);
      extraction = std::make_unique<Extraction>(options, reach, all(), 0_b, 4000);
    }
    graph->build(static_cast<std::uint32_t>(bodies.size()), touches);
    const auto members = extraction->choose(all(), *graph, bodies[0].motion.pose, budget);
    CHECK(std::is_sorted(members.begin(), members.end()));
    return numbers_of(members);
  }
  BodySpan<const physics::Body> all() const { return BodySpan<const physics::Body>(bodies); }
};

bool has(const Chosen& members, std::uint32_t body) {
  return std::find(members.begin(), members.end(), body) != members.end();
}

Chosen range(std::uint32_t end) {
  Chosen result;
  for (std::uint32_t i = 0; i < end; ++i) result.push_back(i);
  return result;
}

}  // namespace

TEST_CASE("The paper's reach is half of the two-cycle reach where nothing turns or comes to meet it") {
  ReachSettings s;
  s.ratio = 8;
  s.tick_period_s = 1e-3;
  s.max_speed_m_per_s = 1;
  s.margin_m = 0;
  s.max_angular_speed_rad_per_s = 0;
  CHECK(reach_of_proxy_m(s, 0.1) == Approx(0.016));
  s.max_angular_speed_rad_per_s = 10;
  CHECK(reach_of_proxy_m(s, 0.1) == Approx(0.032));
  CHECK(reach_of_body_m(s, {{0, 0, 2}, {5, 0, 0}}, 0.2) == Approx(0.016 * (2 + 1)));
  s.reach = Reach::kPaper;
  CHECK(reach_of_proxy_m(s, 0.1) == Approx(0.008));
  CHECK(reach_of_body_m(s, {{0, 0, 2}, {5, 0, 0}}, 0.2) == 0);
}

TEST_CASE("Bodies that intersect the boundary cube are members, others are not") {
  Bench bench(4);
  bench.reach.max_speed_m_per_s = 1;
  bench.reach.max_angular_speed_rad_per_s = 0;
  bench.reach.margin_m = 0;
  // Half side 0.1 + 2 x 10 ms x 1 m/s = 0.12; a ball's own radius is 0.1.
  bench.bodies[1].motion.pose.position = {0.2199, 0, 0};
  bench.bodies[2].motion.pose.position = {0, 0.2201, 0};
  bench.bodies[3].motion.pose.position = {0, 0, -0.25};
  CHECK(bench.choose() == Chosen{0, 1});
  CHECK(bench.extraction->statistics().close == 1);
  SECTION("one that comes closer counts as nearer by two cycles of its speed") {
    bench.bodies[3].motion.velocity.linear = {0, 0, 1.51};  // 0.0302 in 20 ms
    CHECK(bench.choose() == Chosen{0, 1, 3});
  }
  SECTION("so does one that spins") {
    bench.bodies[3].motion.velocity.angular = {15.1, 0, 0};
    CHECK(bench.choose() == Chosen{0, 1, 3});
  }
  SECTION("and a proxy that is thrown faster than the device can move") {
    bench.bodies[0].motion.velocity.linear = {0, 2.6, 0};  // 0.052 in 20 ms
    CHECK(bench.choose() == Chosen{0, 1, 2, 3});
  }
}

TEST_CASE("When the cube holds too many the nearest are members, ties by index") {
  Bench bench(7);
  bench.options.cap = 4;
  bench.reach.max_speed_m_per_s = 10;
  const double gaps[] = {0, 0.05, 0.01, 0.05, 0.02, 0.05, 0.03};
  for (std::uint32_t i = 1; i < 7; ++i)
    bench.bodies[i].motion.pose.position = {(i % 2 == 0 ? 1 : -1) * (0.2 + gaps[i]), 0, 0};
  CHECK(bench.choose() == Chosen{0, 2, 4, 6});
  CHECK(bench.extraction->statistics().close_left_out == 3);
  CHECK(bench.extraction->statistics().dropped == 3);
  bench.options.cap = 5;
  bench.extraction.reset();
  CHECK(bench.choose() == Chosen{0, 1, 2, 4, 6});
}

TEST_CASE("The whole component is in while it fits, whatever its influence") {
  Bench bench(30);
  bench.options.cap = 30;
  bench.options.order = GENERATE(CutOrder::kBestFirst, CutOrder::kBreadthFirst);
  for (std::uint32_t a = 0; a + 1 < 20; ++a) bench.link(a, a + 1);
  bench.bodies[3].mass = 1e5;
  CHECK(bench.choose() == range(20));
  CHECK(bench.extraction->statistics().component == 20);
  CHECK(bench.extraction->statistics().dropped == 0);
}

TEST_CASE("Best first leaves out what is behind a heavy body, breadth first does not") {
  // Two arms of the proxy: 1 - 2 - 3 through the heavy 1, and 4 - 5 - 6.
  Bench bench(7);
  bench.options.cap = 5;
  bench.bodies[1].mass = 1000;
  bench.link(0, 1);
  bench.link(1, 2);
  bench.link(2, 3);
  bench.link(0, 4);
  bench.link(4, 5);
  bench.link(5, 6);
  SECTION("best first") { CHECK(bench.choose() == Chosen{0, 1, 4, 5, 6}); }
  SECTION("breadth first") {
    bench.options.order = CutOrder::kBreadthFirst;
    CHECK(bench.choose() == Chosen{0, 1, 2, 4, 5});
  }
}

TEST_CASE("The proxy is always a member and the cap holds, on any world") {
  std::mt19937 random(5);
  const auto uniform = [&](double low, double high) { return std::uniform_real_distribution<>(low, high)(random); };
  for (int world = 0; world < 20; ++world) {
    Bench bench(80), twin(80);
    for (Bench* b : {&bench, &twin}) {
      b->options.cap = 1 + static_cast<std::uint32_t>(world) * 3;
      b->options.order = world % 2 == 0 ? CutOrder::kBestFirst : CutOrder::kBreadthFirst;
    }
    Chosen before;
    for (int cycle = 0; cycle < 12; ++cycle) {
      for (auto& body : bench.bodies)
        if (body.id != 0) body.motion.pose.position = {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
      bench.touches.clear();
      for (std::uint32_t a = 0; a < 80; ++a)
        for (std::uint32_t b = a + 1; b < 80; ++b)
          if (uniform(0, 1) < 0.03) bench.link(a, b);
      twin.bodies = bench.bodies;
      twin.touches = bench.touches;
      const std::uint32_t budget = cycle < 8 ? 256 : 20;
      const Chosen members = bench.choose(budget);
      REQUIRE(has(members, 0));
      REQUIRE(members.size() <= std::min(bench.options.cap, budget));
      REQUIRE(twin.choose(budget) == members);  // the same input, the same choice

      const auto& s = bench.extraction->statistics();
      Chosen joined, left;
      std::set_difference(members.begin(), members.end(), before.begin(), before.end(), std::back_inserter(joined));
      std::set_difference(before.begin(), before.end(), members.begin(), members.end(), std::back_inserter(left));
      CHECK(joined.size() == s.joins);
      CHECK(left.size() == s.leaves);
      for (const std::uint32_t body : joined) CHECK(bench.extraction->is_joiner(BodyIndex{body}));
      if (cycle > 0) CHECK(s.joins <= bench.options.max_joins + s.close);
      // Bodies of the cube are all in, or the cap is full.
      CHECK((s.close_left_out == 0 || members.size() == std::min(bench.options.cap, budget)));
      before = members;
    }
  }
}

TEST_CASE("The sub-world grows over the cycles, a few joins at a time") {
  Bench bench(60);
  bench.options.cap = 50;
  CHECK(bench.choose() == Chosen{0});
  bench.link_row();
  std::uint32_t expected = 1;
  for (int cycle = 0; cycle < 8; ++cycle) {
    expected = std::min(50u, expected + 8);
    CHECK(bench.choose() == range(expected));
    CHECK(bench.extraction->statistics().dropped == 10);
    CHECK(bench.extraction->statistics().waiting == 50 - expected);
  }
}

TEST_CASE("The cube's bodies join at once, however many, and count against the other joins") {
  Bench bench(40);
  bench.choose();
  for (std::uint32_t i = 1; i <= 12; ++i) bench.bodies[i].motion.pose.position = {0, 0.2, 0.001 * i};
  for (std::uint32_t i = 13; i < 30; ++i) bench.link(i == 13 ? 0 : i - 1, i);
  CHECK(bench.choose() == range(13));
  CHECK(bench.extraction->statistics().joins == 12);
  CHECK(bench.choose() == range(21));
}

TEST_CASE("Membership does not flicker when influence dithers") {
  // Many arms of nearly equal influence compete for the last places; masses dither by 5 %, which moves every tau.
  Bench bench(41);
  bench.options.cap = 15;
  for (std::uint32_t arm = 0; arm < 10; ++arm)
    for (std::uint32_t i = 0; i < 4; ++i) bench.link(i == 0 ? 0 : 1 + 4 * arm + i - 1, 1 + 4 * arm + i);
  const Chosen first = bench.choose();
  std::mt19937 random(9);
  for (int cycle = 0; cycle < 50; ++cycle) {
    for (auto& body : bench.bodies) body.mass = 1 + std::uniform_real_distribution<>(-0.05, 0.05)(random);
    REQUIRE(bench.choose() == first);
    CHECK(bench.extraction->statistics().joins == 0);
  }
}

TEST_CASE("A member gives way to a body of more than twice its influence, and not of less") {
  // Body 1 touches the proxy through nothing but 2 in one arm, 3 through 4 in the other; mass of 4 sets 3's influence:
  // tau = 1 / (1 + M).
  const auto members_with = [](double mass) {
    Bench bench(5);
    bench.options.cap = 4;
    bench.link(0, 2);
    bench.link(2, 1);
    bench.link(0, 4);
    bench.link(4, 3);
    bench.bodies[2].mass = 3;  // influence of 1: 1/4
    bench.bodies[4].mass = 100;
    CHECK(bench.choose() == Chosen{0, 1, 2, 4});
    bench.bodies[4].mass = mass;
    return bench.choose();
  };
  CHECK(members_with(1.1) == Chosen{0, 1, 2, 4});  // 0.476 against 2 x 0.25
  CHECK(members_with(0.9) == Chosen{0, 2, 3, 4});  // 0.526
}

TEST_CASE("A member that no longer qualifies stays four more cycles while there is room") {
  Bench bench(20);
  bench.options.cap = 10;
  bench.link(0, 1);
  bench.link(1, 2);
  CHECK(bench.choose() == Chosen{0, 1, 2});
  bench.touches.clear();
  for (int cycle = 0; cycle < 4; ++cycle) CHECK(bench.choose() == Chosen{0, 1, 2});
  SECTION("then it goes") { CHECK(bench.choose() == Chosen{0}); }
  SECTION("touched again it starts from zero") {
    bench.link(0, 1);
    CHECK(bench.choose() == Chosen{0, 1});
    bench.touches.clear();
    for (int cycle = 0; cycle < 4; ++cycle) CHECK(bench.choose() == Chosen{0, 1});
    CHECK(bench.choose() == Chosen{0});
  }
}

TEST_CASE("One that no longer qualifies gives its place to one that does") {
  Bench bench(20);
  bench.options.cap = 3;
  bench.link(0, 1);
  bench.link(1, 2);
  CHECK(bench.choose() == Chosen{0, 1, 2});
  bench.touches.clear();
  bench.link(0, 7);
  CHECK(bench.choose() == Chosen{0, 1, 7});
}

TEST_CASE("Former members that touch each other leave together, those that do not by themselves") {
  Bench bench(60);
  bench.options.cap = 50;
  bench.link_row();
  bench.choose();
  bench.touches.clear();
  bench.link(0, 1);
  for (unsigned i = 10; i < 29; ++i) bench.link(i, i + 1);  // a group of twenty; all others are alone
  for (int cycle = 0; cycle < 2; ++cycle) CHECK(bench.choose().size() == 50);
  bench.link(1, 20);  // one of the group qualifies again, and with it all
  CHECK(bench.choose().size() == 50);
  bench.touches.pop_back();
  CHECK(bench.choose().size() == 50);
  Chosen group{0, 1};
  for (unsigned i = 10; i < 30; ++i) group.push_back(i);
  CHECK(bench.choose() == group);
  for (int cycle = 0; cycle < 2; ++cycle) CHECK(bench.choose() == group);
  CHECK(bench.choose() == Chosen{0, 1});
  bench.link_row();
  for (int cycle = 0; cycle < 7; ++cycle) bench.choose();
  CHECK(bench.choose(20) == range(20));  // a lower budget takes effect at once
}

TEST_CASE("Work for a far world is not spent: the search stays near the proxy") {
  Bench bench(3000);
  bench.options.cap = 8;
  bench.link_row();
  CHECK(bench.choose() == range(8));
  CHECK(bench.extraction->statistics().component == 3000);
  CHECK(bench.extraction->statistics().dropped == 2992);
}

TEST_CASE("A body of another sub-world is not taken") {
  Bench bench(6);
  bench.link_row();
  bench.choose();
  BodyVector<std::uint8_t> free(6, 1);
  free[2_b] = 0;
  Extraction second(bench.options, bench.reach, bench.all(), 0_b, 100);
  const auto members = second.choose(bench.all(), *bench.graph, {}, 256, free);
  CHECK(numbers_of(members) == Chosen{0, 1, 3, 4, 5});
}

TEST_CASE("All bodies are members when asked for") {
  Bench bench(200);
  bench.options.all_members = true;
  bench.options.cap = 5;
  CHECK(bench.choose() == range(200));
  CHECK(bench.extraction->statistics().joins == 200);
  CHECK(bench.choose(3) == range(200));
  CHECK(bench.extraction->statistics().joins == 0);
}
