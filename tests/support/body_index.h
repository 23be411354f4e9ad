// Body indices and slots in tests: 3_b is BodyIndex{3}, 3_slot is SlotIndex{3}.
#pragma once

#include "rt/physics/slot_index.h"
#include "sim/body_index.h"

namespace tactus::test {

constexpr sim::BodyIndex operator""_b(unsigned long long number) noexcept {
  return sim::BodyIndex{static_cast<std::uint32_t>(number)};
}

constexpr physics::SlotIndex operator""_slot(unsigned long long number) noexcept {
  return physics::SlotIndex{static_cast<std::uint32_t>(number)};
}

// The indices 0 to count - 1: of a world in which every body is awake, by slot.
inline std::vector<sim::BodyIndex> all_awake(std::size_t count) {
  std::vector<sim::BodyIndex> indices;
  for (const sim::BodyIndex body : sim::BodyIndices(count)) indices.push_back(body);
  return indices;
}

}  // namespace tactus::test
