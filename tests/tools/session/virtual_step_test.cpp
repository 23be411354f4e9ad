// What a step of the global world costs on the virtual clock.
#include <catch2/catch.hpp>

#include "tests/system/session_bench.h"

using namespace tactus;

TEST_CASE("searching for contacts takes virtual time, as bodies, contacts and the sub-world's prediction do") {
  const loop::CostModel cost;
  sim::GlobalStatistics last;
  const double nothing_ns = session::global_step_ns(last, 10, 8);
  CHECK(nothing_ns == Approx(cost.fixed));
  last.comparisons = 500;
  CHECK(session::global_step_ns(last, 10, 8) - nothing_ns == Approx(500 * cost.per_search));
  last.comparisons = 0;
  last.awake = 100;
  CHECK(session::global_step_ns(last, 10, 8) - nothing_ns ==
        Approx(100 * (cost.per_body + 10 * cost.per_body_sub_step)));
  last.awake = 0;
  last.prediction = {.members = 5, .sub_steps = 4};
  CHECK(session::global_step_ns(last, 10, 8) - nothing_ns ==
        Approx(8 * (cost.fixed + 5 * (cost.per_body + 4 * cost.per_body_sub_step))));
}

TEST_CASE("a global world counts what it compares while bodies move") {
  auto moving = test::make_session(test::scene_file("domino_row.toml"), test::virtual_options());
  std::uint32_t most = 0;
  test::run(*moving, 2000, [&](const loop::TickOutput&) {
    most = std::max(most, moving->global->statistics().comparisons);
    return true;
  });
  CHECK(most > 0);
  CHECK(moving->global->statistics().comparisons <= most);
}
