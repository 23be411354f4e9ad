#include "rt/base/bounded_vector.h"

#include <catch2/catch.hpp>
#include <random>
#include <vector>

#include "tests/support/rt_guard.h"

using namespace tactus;

TEST_CASE("a bounded vector behaves as a vector that refuses to grow, without allocating", "[base]") {
  constexpr std::uint32_t kCapacity = 17;
  std::mt19937 random(3);
  BoundedVector<int> bounded(kCapacity);
  std::vector<int> model;
  model.reserve(kCapacity);
  std::uint64_t allocations = 0;
  for (int step = 0; step < 20'000; ++step) {
    const auto index = static_cast<std::uint32_t>(random() % (model.size() + 1));
    const auto at = model.begin() + static_cast<std::ptrdiff_t>(index);
    const auto choice = random() % 8;
    const test::RtGuard guard;
    bool agreed = true;
    if (choice < 3) {
      const bool room = model.size() < kCapacity;
      agreed = bounded.try_push(step) == room;
      if (room) model.push_back(step);
    } else if (choice < 5) {
      const bool room = model.size() < kCapacity;
      agreed = bounded.try_insert(index, step) == room;
      if (room) model.insert(at, step);
    } else if (choice < 7 && index < model.size()) {
      bounded.erase(index);
      model.erase(at);
    } else if (random() % 50 == 0) {
      bounded.clear();
      model.clear();
    }
    allocations += guard.allocations();
    REQUIRE(agreed);
    REQUIRE(std::equal(model.begin(), model.end(), bounded.begin(), bounded.end()));
    REQUIRE(bounded.full() == (model.size() == kCapacity));
    REQUIRE(bounded.empty() == model.empty());
  }
  CHECK(allocations == 0);
}

TEST_CASE("swapping two bounded vectors exchanges contents and capacities", "[base]") {
  BoundedVector<int> a(2), b(3);
  REQUIRE(a.try_push(1));
  a.swap(b);
  CHECK(a.capacity() == 3);
  CHECK(a.empty());
  CHECK(b.size() == 1);
  CHECK(b[0] == 1);
}

TEST_CASE("a fixed vector refuses at its capacity and keeps what it has", "[base]") {
  FixedVector<int, 3> fixed;
  for (int i = 0; i < 3; ++i) CHECK(fixed.try_push(i));
  CHECK(!fixed.try_push(3));
  CHECK(fixed.size() == 3);
  CHECK(fixed[2] == 2);
  fixed.clear();
  CHECK(fixed.empty());
  CHECK(fixed.try_push(9));
  CHECK(fixed.span().front() == 9);
}
