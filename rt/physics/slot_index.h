// The index of a body among the dynamic bodies of a world: its rank by id. It changes when a body with a lower id is
// inserted or removed, so it is not an id, nor an index of another world; none of these converts to it. Within the
// engine slots are plain integers: loop counters, and lanes of a row. Costs no instruction. Thread: [any].
#pragma once

#include <cstdint>

namespace tactus::physics {

enum class SlotIndex : std::uint32_t {};

constexpr std::uint32_t number_of(SlotIndex slot) noexcept { return static_cast<std::uint32_t>(slot); }

}  // namespace tactus::physics
