#include "rt/physics/effects/effects.h"

namespace tactus::physics {
namespace {

// Calls `f(effect object)` for every effect in use, in the order of the list.
template <class Rooms, class F>
void for_each_room(Rooms& rooms, F&& f) noexcept {
  std::apply(
      [&](auto&... room) noexcept {
        const auto visit = [&](auto& one) noexcept {
          if (one != nullptr) f(*one);
        };
        (visit(room), ...);
      },
      rooms);
}

}  // namespace

Effects::Effects(const EffectSetups& setups, const Capacities& capacities) {
  const auto open = [&]<class Room>(std::unique_ptr<Room>& room) {
    const auto& setup = std::get<typename Room::Setup>(setups);
    if (!setup.used()) return;
    room = std::make_unique<Room>(setup, capacities);
    room->enter(stages_);
  };
  std::apply([&](auto&... room) { (open(room), ...); }, rooms_);
}

bool Effects::only_gravity() const noexcept {
  std::uint32_t others = 0;
  for_each_room(rooms_, [&]<class Room>(const Room&) noexcept { others += std::is_same_v<Room, Gravity> ? 0 : 1; });
  return others == 0;
}

void Effects::reset() noexcept {
  for_each_room(rooms_, [](auto& room) noexcept { room.reset(); });
}

void Effects::save(ByteWriter& out) const noexcept {
  for_each_room(rooms_, [&](const auto& room) noexcept { room.save(out); });
}

bool Effects::restore(ByteReader& in) noexcept {
  bool good = true;
  for_each_room(rooms_, [&](auto& room) noexcept { good = room.restore(in) && good; });
  return good;
}

std::size_t Effects::save_size_bound() const noexcept {
  std::size_t bytes = 0;
  for_each_room(rooms_, [&](const auto& room) noexcept { bytes += room.save_size_bound(); });
  return bytes;
}

void Effects::export_state(ByteWriter& out, std::span<const Body> bodies,
                           std::span<const std::uint8_t> inside) const noexcept {
  for_each_room(rooms_, [&](const auto& room) noexcept { room.export_state(out, bodies, inside); });
}

bool Effects::import_state(ByteReader& in, std::span<const Body> bodies, bool known_too) noexcept {
  bool good = true;
  for_each_room(rooms_, [&](auto& room) noexcept { good = good && room.import_state(in, bodies, known_too); });
  return good;
}

}  // namespace tactus::physics
