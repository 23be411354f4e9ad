// What the tests of broad phases share: pairs in an order of their own, and all of them by brute force.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <utility>
#include <vector>

#include "rt/physics/collision/pair_finder.h"

namespace tactus::test {

using Boxes = std::vector<physics::Aabb>;
using Keys = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

// The lower body first.
inline Keys sorted_keys(const BoundedVector<physics::SlotPair>& pairs) {
  Keys keys;
  for (const auto& pair : pairs) keys.emplace_back(std::min(pair.a, pair.b), std::max(pair.a, pair.b));
  std::sort(keys.begin(), keys.end());
  return keys;
}

// A list for all pairs that so many boxes can make.
inline BoundedVector<physics::SlotPair> list_for_pairs(const Boxes& boxes) {
  return BoundedVector<physics::SlotPair>(static_cast<std::uint32_t>(boxes.size() * boxes.size() / 2 + 1));
}

inline Keys by_brute_force(const Boxes& boxes) {
  auto pairs = list_for_pairs(boxes);
  REQUIRE(physics::find_pairs_brute_force(boxes, pairs));
  return sorted_keys(pairs);
}

}  // namespace tactus::test
