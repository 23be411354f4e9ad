#include "tools/experiment/coupling/energy_measures.h"

#include <catch2/catch.hpp>

using namespace tactus::experiment;

TEST_CASE("A window that won does not hide one that lost") {
  EnergyBook book;
  book.add({0.9, 1}, {1, 1}, 0);  // a tenth lost
  book.close_window();
  book.add({3.3, 1}, {3, 1}, 0);  // a tenth gained, of more
  book.close_window();
  CHECK(book.kinetic().loss == Approx(0.1 / 4));
  CHECK(book.kinetic().gain == Approx(0.3 / 4));
  CHECK(book.speed_squared().loss == 0);
  CHECK(book.worst_instant().loss == Approx(0.1 / 3));
  CHECK(book.worst_instant().gain == Approx(0.3 / 3));
}

TEST_CASE("Within a window only the sum counts, in the worst instant each") {
  EnergyBook book;
  book.add({0.5, 0}, {1, 0}, 0);
  book.add({1.5, 0}, {1, 0}, 0);
  book.close_window();
  CHECK(book.kinetic().loss == 0);
  CHECK(book.kinetic().gain == 0);
  CHECK(book.worst_instant().loss == Approx(0.5));
}

TEST_CASE("Books of several hands add up, and an empty one says nothing") {
  EnergyBook one, two;
  one.add({0.9, 0.8}, {1, 1}, 0);
  one.close_window();
  two.add({1, 1}, {1, 1}, 0);
  two.close_window();
  one.add(two);
  CHECK(one.kinetic().loss == Approx(0.05));
  CHECK(one.speed_squared().loss == Approx(0.1));
  CHECK(EnergyBook{}.kinetic().loss == 0);
  CHECK(EnergyBook{}.worst_instant().gain == 0);
}

TEST_CASE("In a scene at rest the spring's energy is what there is to lose") {
  EnergyBook book;
  book.add({1e-6, 0}, {0, 0}, 1e-3);
  book.close_window();
  CHECK(book.at_rest());
  CHECK(book.kinetic().gain == Approx(1e-3));
  CHECK(book.worst_instant().gain == Approx(1e-3));
  book.add({0.9e-3, 0}, {1e-3, 0}, 1e-3);
  book.close_window();
  CHECK_FALSE(book.at_rest());
  CHECK(book.kinetic().loss == Approx(0.1));
}
