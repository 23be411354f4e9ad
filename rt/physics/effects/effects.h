// The effects of a world: the effect objects in use, and the table of their stages.
//
// An effect object is made only if its Setup is used(): an unused effect has no memory and no stage. Thread:
// construction [setup]; the rest [rt], the owner of the World. Bound: that of the effects.
#pragma once

#include <memory>

#include "rt/physics/effects/effect_list.h"

namespace tactus::physics {

namespace effects_detail {
template <class Objects>
struct Of;
template <class... Object>
struct Of<std::tuple<Object...>> {
  using Setups = std::tuple<typename Object::Setup...>;
  using Held = std::tuple<std::unique_ptr<Object>...>;
};
}  // namespace effects_detail

// The setups of all effects; std::get<Joints::Setup>(setups) is that of the joints. Default: gravity only.
using EffectSetups = effects_detail::Of<EffectObjects>::Setups;

class Effects {
 public:
  Effects(const EffectSetups& setups, const Capacities& capacities);

  const StageTable& stages() const noexcept { return stages_; }
  // Null if the effect is not used.
  template <class Object>
  Object* find() noexcept {
    return std::get<std::unique_ptr<Object>>(objects_).get();
  }
  template <class Object>
  const Object* find() const noexcept {
    return std::get<std::unique_ptr<Object>>(objects_).get();
  }

  // True if every effect in use can run with sweeps in single precision: gravity, and bodies that follow a script.
  bool suit_single_precision() const noexcept;

  // Resets all effects to their initial state: no joint broken, times at 0.
  void reset() noexcept;

  // Saves the state on which the next step depends. The restoring world must have the same effects.
  void save(ByteWriter& out) const noexcept;
  [[nodiscard]] bool restore(ByteReader& in) noexcept;
  std::size_t save_size_bound() const noexcept;

  // Transfer between two worlds with the same effects. Exports the state of the bodies that are `inside` (by slot;
  // empty: all).
  void export_state(ByteWriter& out, std::span<const Body> bodies, std::span<const std::uint8_t> inside) const noexcept;
  // `known_too`: also imports the state of bodies that this world has already; broken joints are always imported.
  // Returns false if the bytes were not written by export_state; what was read before the error stays imported.
  bool import_state(ByteReader& in, std::span<const Body> bodies, bool known_too) noexcept;

 private:
  effects_detail::Of<EffectObjects>::Held objects_;
  StageTable stages_;
};

}  // namespace tactus::physics
