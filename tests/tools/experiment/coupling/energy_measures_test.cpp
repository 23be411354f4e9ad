#include "tools/experiment/coupling/energy_measures.h"

#include <catch2/catch.hpp>

using namespace tactus::experiment;

TEST_CASE("A window that won does not hide one that lost") {
  EnergyDeviation balance;
  balance.add({0.9, 1}, {1, 1}, 0);  // a tenth lost
  balance.close_window();
  balance.add({3.3, 1}, {3, 1}, 0);  // a tenth gained, of more
  balance.close_window();
  CHECK(balance.kinetic().loss == Approx(0.1 / 4));
  CHECK(balance.kinetic().gain == Approx(0.3 / 4));
  CHECK(balance.speed_squared().loss == 0);
  CHECK(balance.worst_instant().loss == Approx(0.1 / 3));
  CHECK(balance.worst_instant().gain == Approx(0.3 / 3));
}

TEST_CASE("Within a window only the sum counts, in the worst instant each") {
  EnergyDeviation balance;
  balance.add({0.5, 0}, {1, 0}, 0);
  balance.add({1.5, 0}, {1, 0}, 0);
  balance.close_window();
  CHECK(balance.kinetic().loss == 0);
  CHECK(balance.kinetic().gain == 0);
  CHECK(balance.worst_instant().loss == Approx(0.5));
}

TEST_CASE("The energies of several hands add up, and an empty one says nothing") {
  EnergyDeviation one, two;
  one.add({0.9, 0.8}, {1, 1}, 0);
  one.close_window();
  two.add({1, 1}, {1, 1}, 0);
  two.close_window();
  one.add(two);
  CHECK(one.kinetic().loss == Approx(0.05));
  CHECK(one.speed_squared().loss == Approx(0.1));
  CHECK(EnergyDeviation{}.kinetic().loss == 0);
  CHECK(EnergyDeviation{}.worst_instant().gain == 0);
}

TEST_CASE("In a scene at rest the spring's energy is what there is to lose") {
  EnergyDeviation balance;
  balance.add({1e-6, 0}, {0, 0}, 1e-3);
  balance.close_window();
  CHECK(balance.at_rest());
  CHECK(balance.kinetic().gain == Approx(1e-3));
  CHECK(balance.worst_instant().gain == Approx(1e-3));
  balance.add({0.9e-3, 0}, {1e-3, 0}, 1e-3);
  balance.close_window();
  CHECK_FALSE(balance.at_rest());
  CHECK(balance.kinetic().loss == Approx(0.1));
}
