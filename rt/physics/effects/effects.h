// The effects that a world has: their rooms, and the table of stages that comes of them.
//
// A room is made only where its Setup says that it is used: an effect without use has no memory and no stage. Thread:
// construction [setup]; the rest [rt], the owner of the World. Bound: that of the rooms.
#pragma once

#include <memory>

#include "rt/physics/effects/effect_list.h"

namespace tactus::physics {

namespace effects_detail {
template <class Rooms>
struct Of;
template <class... Room>
struct Of<std::tuple<Room...>> {
  using Setups = std::tuple<typename Room::Setup...>;
  using Held = std::tuple<std::unique_ptr<Room>...>;
};
}  // namespace effects_detail

// What each effect is told; std::get<Joints::Setup>(setups) is that of the joints. Without a word: gravity alone.
using EffectSetups = effects_detail::Of<EffectRooms>::Setups;

class Effects {
 public:
  Effects(const EffectSetups& setups, const Capacities& capacities);

  const StageTable& stages() const noexcept { return stages_; }
  // Null where the effect is not used.
  template <class Room>
  const Room* find() const noexcept {
    return std::get<std::unique_ptr<Room>>(rooms_).get();
  }

  bool only_gravity() const noexcept;  // or nothing

  // Back to how they were made: nothing broken, no time gone.
  void reset() noexcept;

  // What the next step depends on. The reading world has the same effects.
  void save(ByteWriter& out) const noexcept;
  [[nodiscard]] bool restore(ByteReader& in) noexcept;
  std::size_t save_size_bound() const noexcept;

  // Between two worlds with the same effects: what the rooms hold of the bodies that are `inside` (by slot; empty:
  // all).
  void export_state(ByteWriter& out, std::span<const Body> bodies, std::span<const std::uint8_t> inside) const noexcept;
  // `known_too`: also of bodies that this world has already; what broke is always believed. False where the bytes are
  // none that export_state wrote: what was read up to there counts.
  bool import_state(ByteReader& in, std::span<const Body> bodies, bool known_too) noexcept;

 private:
  effects_detail::Of<EffectRooms>::Held rooms_;
  StageTable stages_;
};

}  // namespace tactus::physics
