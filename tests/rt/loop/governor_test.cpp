#include "rt/loop/governor.h"

#include <catch2/catch.hpp>

#include "tests/support/bits.h"
#include "tests/support/physics_bench.h"

using namespace tactus;
using namespace tactus::loop;

namespace {

// One number for each term, so that a sum says which are in it.
CostModel decimal_cost() {
  CostModel cost;
  cost.fixed = 1;
  cost.per_body = 10;
  cost.per_pair = 100;
  cost.per_contact = 1e3;
  cost.per_point_sub_step = 1e4;
  cost.per_body_sub_step = 1e5;
  cost.per_border_sub_step = 1e6;
  cost.synchronisation = 1e7;
  cost.per_join = 1e8;
  cost.per_contact_sub_step = 1e9;
  cost.per_border = 1e10;
  cost.per_search = 1e11;
  cost.per_border_synchronised = 1e12;
  return cost;
}

// Cubes in a heap, all of which move: what grows with the members.
WorkCounts heap(std::uint32_t bodies) {
  WorkCounts counts;
  counts.bodies = bodies;
  counts.pairs = counts.comparisons = 6 * bodies;
  counts.contacts = 3 * bodies;
  counts.points = 12 * bodies;
  counts.border = bodies;
  return counts;
}

GovernorConfig make_config() {
  GovernorConfig config;
  config.sub_steps = 8;
  config.min_sub_steps = 2;
  return config;
}

double budget_of(const GovernorConfig& config) { return config.budget * config.period_ns; }

}  // namespace

TEST_CASE("the prediction counts every unit of work once, and sub-steps where they repeat") {
  const CostModel cost = decimal_cost();
  WorkCounts counts;
  CHECK(predict_ns(cost, counts, 3) == 1);
  counts.bodies = 1;
  CHECK(predict_ns(cost, counts, 3) == 1 + 10 + 3 * 1e5);
  counts.pairs = 2;
  counts.contacts = 3;
  counts.points = 4;
  counts.border = 5;
  counts.comparisons = 6;
  const double without = 1 + 10 + 2 * 100 + 3 * 1e3 + 5 * 1e10 + 6 * 1e11 + 3 * (4 * 1e4 + 1e5 + 5 * 1e6 + 3 * 1e9);
  CHECK(predict_ns(cost, counts, 3) == without);
  counts.synchronises = true;
  CHECK(predict_ns(cost, counts, 3) == without + 1e7 + 5 * 1e12);
  counts.joins = 1;
  const double joining = without + 1e7 + 5 * 1e12 + 1e8;
  CHECK(predict_ns(cost, counts, 3) == joining);
  // A joiner is a body with six contacts of four points that no count knows yet.
  CHECK(predict_ns(cost, with_joiners(counts), 3) ==
        joining + 10 + 6 * (100 + 1e3 + 1e11) + 3 * (24 * 1e4 + 1e5 + 6 * 1e9));
}

TEST_CASE("what fits is done with all sub-steps") {
  const GovernorConfig config = make_config();
  Governor governor(config);
  const TickPlan plan = governor.plan(heap(2));
  CHECK(plan.sub_steps == 8);
  CHECK(plan.reduced == 0);
  CHECK(plan.predicted_ns == predict_ns(config.cost, heap(2), 8));
}

TEST_CASE("sub-steps fall with the counts, stay within their bounds, and are the most that the budget allows") {
  test::Random random(7);
  for (int scene = 0; scene < 50; ++scene) {
    GovernorConfig config = make_config();
    config.period_ns = random(2e5, 2e6);
    config.budget = random(0.3, 0.8);
    Governor governor(config);
    std::uint32_t before = config.sub_steps;
    WorkCounts counts;
    for (int i = 0; i < 60; ++i) {
      const auto more = [&] { return static_cast<std::uint32_t>(random(0, 30)); };
      counts.bodies += more();
      counts.pairs += more();
      counts.contacts += more();
      counts.points += more();
      counts.border += more();
      counts.joins += more() / 10;
      counts.comparisons = counts.pairs;
      const TickPlan plan = governor.plan(counts);
      REQUIRE(plan.sub_steps <= before);
      REQUIRE(plan.sub_steps >= config.min_sub_steps);
      REQUIRE(plan.reduced == (plan.sub_steps < config.sub_steps ? 1u : 0u));
      REQUIRE(plan.predicted_ns == predict_ns(config.cost, with_joiners(counts), plan.sub_steps));
      if (plan.sub_steps > config.min_sub_steps) REQUIRE(plan.predicted_ns <= budget_of(config));
      if (plan.sub_steps < config.sub_steps)
        REQUIRE(predict_ns(config.cost, with_joiners(counts), plan.sub_steps + 1) > budget_of(config));
      REQUIRE(test::same_bits(plan, governor.plan(counts)));
      before = plan.sub_steps;
    }
    CHECK(before == config.min_sub_steps);
  }
}

TEST_CASE("a tick that adopts many joiners is planned for them") {
  Governor governor(make_config());
  WorkCounts counts = heap(20);
  const std::uint32_t usual = governor.plan(counts).sub_steps;
  counts.synchronises = true;
  counts.joins = 20;
  CHECK(governor.plan(counts).sub_steps < usual);
}

TEST_CASE("after a burst of searches the next ticks are planned for some, and then for none") {
  Governor governor(make_config());
  const WorkCounts burst = heap(20);
  WorkCounts calm = burst;
  calm.comparisons = 0;
  const double at_rest_ns = governor.plan(calm).predicted_ns, in_burst_ns = governor.plan(burst).predicted_ns;
  REQUIRE(at_rest_ns < in_burst_ns);
  double before_ns = in_burst_ns;
  for (int tick = 0; tick < 100; ++tick) {
    const double now_ns = governor.plan(calm).predicted_ns;
    REQUIRE(now_ns <= before_ns);
    if (tick == 5) CHECK(now_ns > 0.5 * (at_rest_ns + in_burst_ns));
    before_ns = now_ns;
  }
  CHECK(before_ns == at_rest_ns);
}

TEST_CASE("shapes that are dearer than boxes are planned for, and not forgotten where all pairs are searched") {
  Governor governor(make_config());
  WorkCounts boxes = heap(4);
  WorkCounts hulls = boxes;
  hulls.comparisons = 9 * boxes.pairs;  // of 64 vertices
  const double dearer_ns = governor.config().cost.per_search * 8 * boxes.pairs;
  const double boxes_ns = governor.plan(boxes).predicted_ns;
  CHECK(governor.plan(hulls).predicted_ns == Approx(boxes_ns + dearer_ns));
  CHECK(with_all_compared(hulls).comparisons == hulls.comparisons);
  CHECK(with_all_compared(boxes).comparisons == boxes.pairs);
}

TEST_CASE("the member budget is that of a sub-world in which nothing is carried over") {
  GovernorConfig config = make_config();
  config.members = 256;
  WorkCounts calm = heap(256);
  calm.comparisons = 0;
  Governor resting(config), moving(config);
  CHECK(resting.member_budget(calm) == moving.member_budget(heap(256)));
}

TEST_CASE("the member budget falls at once to what fits with the fewest sub-steps") {
  GovernorConfig config = make_config();
  config.members = 256;
  config.cost.fixed = GENERATE(8e3, 3e5);  // little and much that no member can save
  Governor governor(config);
  REQUIRE(predict_ns(config.cost, heap(256), config.min_sub_steps) > budget_of(config));
  const std::uint32_t members = governor.member_budget(heap(256));
  CHECK(predict_ns(config.cost, heap(members), config.min_sub_steps) <= budget_of(config));
  CHECK(predict_ns(config.cost, heap(members + 1), config.min_sub_steps) > budget_of(config));
}

TEST_CASE("the member budget rises by one a cycle, with a fifth to spare, and not beyond the members asked for") {
  GovernorConfig config = make_config();
  config.members = 128;
  Governor governor(config);
  std::uint32_t before = governor.member_budget(heap(400));
  REQUIRE(before < 128);
  // Between four fifths and the whole it stays.
  std::uint32_t near = 1;
  while (predict_ns(config.cost, heap(near), config.min_sub_steps) < 0.9 * budget_of(config)) ++near;
  REQUIRE(predict_ns(config.cost, heap(near), config.min_sub_steps) < budget_of(config));
  for (int i = 0; i < 10; ++i) CHECK(governor.member_budget(heap(near)) == before);
  for (int i = 0; i < 200; ++i) {
    const std::uint32_t now = governor.member_budget(heap(1));
    REQUIRE(now == std::min(before + 1, 128u));
    before = now;
  }
  CHECK(before == 128);
}

TEST_CASE("the member budget never falls below its least, nor above what was asked for") {
  GovernorConfig config = make_config();
  config.cost.fixed = 1e9;  // nothing ever fits
  SECTION("the least") {
    Governor governor(config);
    CHECK(governor.member_budget(heap(64)) == config.min_members);
  }
  SECTION("asked for fewer than the least") {
    config.members = 4;
    Governor governor(config);
    for (int i = 0; i < 5; ++i) CHECK(governor.member_budget(heap(64)) == 4);
  }
}

TEST_CASE("two governors with the same counts decide the same") {
  test::Random random(11);
  GovernorConfig config = make_config();
  config.members = 200;
  Governor first(config), second(config);
  for (int i = 0; i < 500; ++i) {
    const WorkCounts counts = heap(static_cast<std::uint32_t>(random(1, 300)));
    REQUIRE(first.member_budget(counts) == second.member_budget(counts));
    REQUIRE(test::same_bits(first.plan(counts), second.plan(counts)));
  }
}
