// A snapshot as bytes for the tape: only the entries that are used. Thread: write [rt]; read [setup], replay.
// Bound: snapshot_bytes_bound(). Reading checks every count and what the sub-world takes for granted (members
// ascending, joiners that are bodies, triangles that are there); false on bytes that no writer made.
#pragma once

#include "rt/base/bytes.h"
#include "rt/haptics/coupling/snapshot.h"

namespace tactus::haptics {

void write_snapshot(ByteWriter& out, const WorldSnapshot& snapshot) noexcept;
// `hulls`: how many the sub-world knows; `meshes`: those that it knows.
[[nodiscard]] bool read_snapshot(ByteReader& in, WorldSnapshot& snapshot, std::size_t hulls = 0,
                                 physics::Meshes meshes = {}) noexcept;

// What the world's effects hold of its bodies `inside` (by slot; empty: all). False, and none, where it does not fit.
bool write_effects(const physics::World& world, std::span<const std::uint8_t> inside, EffectBytes& out) noexcept;
// The other way: `known_too`: also of bodies that the world has already. What is damaged is left out.
void read_effects(const EffectBytes& in, bool known_too, physics::World& world) noexcept;
constexpr std::size_t snapshot_bytes_bound() noexcept { return sizeof(WorldSnapshot); }

}  // namespace tactus::haptics
