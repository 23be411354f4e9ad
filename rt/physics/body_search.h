// Finds a body by its id among bodies sorted by id. Thread: [any]; pure. Bound: log(bodies).
#pragma once

#include <algorithm>
#include <span>

#include "rt/physics/body.h"
#include "rt/physics/contact/contact.h"

namespace tactus::physics {

// Returns the body's index, or kNoSlot.
inline std::uint32_t find_slot(std::span<const Body> bodies, BodyId id) noexcept {
  const auto at = std::lower_bound(bodies.begin(), bodies.end(), id, [](const Body& b, BodyId i) { return b.id < i; });
  return at != bodies.end() && at->id == id ? static_cast<std::uint32_t>(at - bodies.begin()) : kNoSlot;
}

}  // namespace tactus::physics
