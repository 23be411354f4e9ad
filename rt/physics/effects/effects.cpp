#include "rt/physics/effects/effects.h"

namespace tactus::physics {
namespace {

// Calls `f(effect object)` for every effect in use, in the order of the list.
template <class Objects, class F>
void for_each_object(Objects& objects, F&& f) noexcept {
  std::apply(
      [&](auto&... object) noexcept {
        const auto visit = [&](auto& one) noexcept {
          if (one != nullptr) f(*one);
        };
        (visit(object), ...);
      },
      objects);
}

}  // namespace

Effects::Effects(const EffectSetups& setups, const Capacities& capacities) {
  const auto open = [&]<class Object>(std::unique_ptr<Object>& object) {
    const auto& setup = std::get<typename Object::Setup>(setups);
    if (!setup.used()) return;
    object = std::make_unique<Object>(setup, capacities);
    object->register_stages(stages_);
  };
  std::apply([&](auto&... object) { (open(object), ...); }, objects_);
}

bool Effects::suit_single_precision() const noexcept {
  std::uint32_t others = 0;
  for_each_object(objects_, [&]<class Object>(const Object&) noexcept {
    others += std::is_same_v<Object, Gravity> || std::is_same_v<Object, ScriptedMotion> ? 0 : 1;
  });
  return others == 0;
}

void Effects::reset() noexcept {
  for_each_object(objects_, [](auto& object) noexcept { object.reset(); });
}

void Effects::save(ByteWriter& out) const noexcept {
  for_each_object(objects_, [&](const auto& object) noexcept { object.save(out); });
}

bool Effects::restore(ByteReader& in) noexcept {
  bool good = true;
  for_each_object(objects_, [&](auto& object) noexcept { good = object.restore(in) && good; });
  return good;
}

std::size_t Effects::save_size_bound() const noexcept {
  std::size_t bytes = 0;
  for_each_object(objects_, [&](const auto& object) noexcept { bytes += object.save_size_bound(); });
  return bytes;
}

void Effects::export_state(ByteWriter& out, std::span<const Body> bodies,
                           std::span<const std::uint8_t> inside) const noexcept {
  for_each_object(objects_, [&](const auto& object) noexcept { object.export_state(out, bodies, inside); });
}

bool Effects::import_state(ByteReader& in, std::span<const Body> bodies, bool known_too) noexcept {
  bool good = true;
  for_each_object(objects_, [&](auto& object) noexcept { good = good && object.import_state(in, bodies, known_too); });
  return good;
}

}  // namespace tactus::physics
