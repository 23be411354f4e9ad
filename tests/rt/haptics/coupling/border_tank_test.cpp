#include "rt/haptics/coupling/border_tank.h"

#include <catch2/catch.hpp>
#include <random>

using tactus::haptics::BorderTank;

TEST_CASE("What border and corrections supply is bounded by the start, the outside bodies' work, and what is owed") {
  std::mt19937_64 random(GENERATE(range(1u, 21u)));
  std::uniform_real_distribution<double> uniform(-1e-3, 1e-3);
  BorderTank tank;
  tank.start(0.01);
  double supplied = 0, outside = 0;
  for (int cycle = 0; cycle < 2000; ++cycle) {
    for (int tick = 0; tick < 8; ++tick) {
      const double owed = tank.owed_J;
      const double work = std::min(3 * uniform(random), std::max(0.0, tank.available_J()));
      tank.settle(-work);
      supplied += work;
      REQUIRE(tank.owed_J <= owed);  // rows that keep to what is available owe nothing more
      REQUIRE(supplied <= 0.01 + outside + tank.owed_J + 1e-12);
    }
    const double global = 8 * uniform(random), corrections = uniform(random);
    tank.settle(-corrections);
    tank.settle(global);
    tank.keep_capacity();
    supplied += corrections;
    outside += global;
    REQUIRE(tank.stored_J >= 0);
    REQUIRE(tank.owed_J >= 0);
    REQUIRE(tank.stored_J * tank.owed_J == 0);
    REQUIRE(tank.stored_J <= BorderTank::kMaxStored_J);
    REQUIRE(supplied <= 0.01 + outside + tank.owed_J + 1e-12);
  }
}

TEST_CASE("What goes beyond what is available is owed, and paid before anything is stored") {
  BorderTank tank;
  tank.start(0.01);
  tank.settle(-0.03);
  CHECK(tank.empty(0.01));
  CHECK(tank.owed_J == Approx(0.02));
  CHECK(tank.available_J() == Approx(-0.02));
  tank.settle(0.015);
  CHECK(tank.empty(0.01));
  tank.settle(0.015);
  CHECK(tank.stored_J == Approx(0.01));
  CHECK(tank.owed_J == 0);
}

TEST_CASE("A share of the outside bodies' kinetic energy may be owed, and stays owed when they have come to rest") {
  BorderTank tank;
  tank.start(0.01);
  tank.lend(0.4);
  CHECK(tank.available_J() == Approx(0.01 + 0.4 * BorderTank::kCreditShare));
  tank.settle(-0.1);
  CHECK(!tank.empty(0.01));
  tank.lend(0);
  CHECK(tank.empty(0.01));
  CHECK(tank.available_J() == Approx(-0.09));
}

TEST_CASE("What was dissipated fills the tank up to the amount at the start, no further") {
  BorderTank tank;
  tank.start(-0.002);
  CHECK(tank.refill(0.005, 0.01) == Approx(0.005));
  CHECK(tank.stored_J == Approx(0.003));
  CHECK(tank.refill(0.02, 0.01) == Approx(0.007));
  CHECK(tank.stored_J == Approx(0.01));
  tank.settle(0.05);
  CHECK(tank.refill(0.02, 0.01) == 0);
  CHECK(tank.stored_J == Approx(0.06));
}

TEST_CASE("An impact beyond the capacity is whole until both sides of it are settled") {
  BorderTank tank;
  tank.start(0.01);
  tank.settle(0.22);   // the border takes the impact from the members,
  tank.settle(-0.24);  // the outside bodies took it in the global step,
  tank.settle(0.018);  // and the corrections the rest
  tank.keep_capacity();
  CHECK(tank.stored_J == Approx(0.008));
  tank.settle(0.3);
  tank.keep_capacity();
  CHECK(tank.stored_J == BorderTank::kMaxStored_J);
}
