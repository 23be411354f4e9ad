#include "rt/haptics/coupling/border_tank.h"

#include <catch2/catch.hpp>
#include <random>

using tactus::haptics::BorderTank;

TEST_CASE("a border whose rows keep to the budget puts in no more than was there and what came in") {
  std::mt19937_64 random(GENERATE(range(1u, 21u)));
  std::uniform_real_distribution<double> uniform(-1e-3, 1e-3);
  BorderTank tank;
  tank.start(0.01);
  double put_in = 0, came_in = 0;
  for (int tick = 0; tick < 10000; ++tick) {
    const double credit = uniform(random), wanted = 3 * uniform(random);
    const double work = std::min(wanted, tank.budget_J(credit));
    tank.settle(credit - work);
    put_in += work;
    came_in += std::max(0.0, credit);
    REQUIRE(tank.stored_J >= 0);
    REQUIRE(tank.owed_J >= 0);
    REQUIRE(tank.stored_J * tank.owed_J == 0);
    REQUIRE(tank.stored_J <= BorderTank::kMaxStored_J);
    REQUIRE(put_in <= 0.01 + came_in + 1e-12);
  }
}

TEST_CASE("what goes beyond the budget is owed, and paid before anything is stored") {
  BorderTank tank;
  tank.start(0.01);
  tank.settle(-0.03);
  CHECK(tank.empty());
  CHECK(tank.owed_J == Approx(0.02));
  CHECK(tank.budget_J(0) == Approx(-0.02));
  CHECK(tank.budget_J(0.05) == Approx(0.03));
  CHECK(tank.budget_J(-0.05) == Approx(-0.02));  // what outside bodies took is settled, no budget
  tank.settle(0.015);
  CHECK(tank.empty());
  tank.settle(0.015);
  CHECK(tank.stored_J == Approx(0.01));
  CHECK(tank.owed_J == 0);
}
