// Serialises a snapshot for the tape: only the used entries. Thread: write [rt]; read [setup], replay. Bound:
// snapshot_bytes_bound(). Reading checks every count and every precondition of the sub-world (members ascending,
// joiners that are valid bodies, triangles that exist); it returns false for bytes that no writer produced.
#pragma once

#include "rt/base/bytes.h"
#include "rt/haptics/coupling/snapshot.h"

namespace tactus::haptics {

void write_snapshot(ByteWriter& out, const WorldSnapshot& snapshot) noexcept;
// `shapes`: the sub-world's.
[[nodiscard]] bool read_snapshot(ByteReader& in, WorldSnapshot& snapshot,
                                 const physics::ShapeLists& shapes = {}) noexcept;

// Exports the state of the world's effects for the bodies `inside` (by slot; empty: all). If it does not fit: false,
// and `out` is empty.
bool write_effects(const physics::World& world, std::span<const std::uint8_t> inside, EffectBytes& out) noexcept;
// Imports the same. `known_too`: also for bodies that the world already has. Damaged entries are skipped.
void read_effects(const EffectBytes& in, bool known_too, physics::World& world) noexcept;
constexpr std::size_t snapshot_bytes_bound() noexcept { return sizeof(WorldSnapshot); }

}  // namespace tactus::haptics
