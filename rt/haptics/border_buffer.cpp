#include "rt/haptics/border_buffer.h"

#include <functional>

namespace tactus::haptics {

double BorderBuffer::adopt(const WorldSnapshot& snapshot, physics::World<double>& world) noexcept {
  double gained_J = 0;
  for (const MemberMotion& renewed : snapshot.renewed) {
    const std::int32_t slot = world.slot_of(renewed.id);
    if (slot < 0 || !holds(renewed.id)) continue;
    auto& body = world.bodies()[static_cast<std::uint32_t>(slot)];
    gained_J -= kinetic_energy(body);
    body.motion = renewed.motion;
    gained_J += kinetic_energy(body);
  }
  bodies_.clear();
  for (const BodyId id : snapshot.buffer)
    if (world.slot_of(id) >= 0) (void)bodies_.try_push(id);  // members: never more than fit
  return gained_J;
}

void BorderBuffer::save(ByteWriter& out) const noexcept {
  out.put(bodies_.size());
  out.put_all(bodies_.span());
}

bool BorderBuffer::restore(ByteReader& in, const physics::World<double>& world) noexcept {
  clear();
  std::uint32_t count = 0;
  in.get(count);
  if (!in.ok() || count > kMaxMembers) return false;
  bodies_.resize(count);
  in.get_all(bodies_.span());
  if (!in.ok() || std::adjacent_find(bodies_.begin(), bodies_.end(), std::greater_equal<>()) != bodies_.end())
    return false;
  return std::all_of(bodies_.begin(), bodies_.end(), [&](BodyId id) { return world.slot_of(id) >= 0; });
}

}  // namespace tactus::haptics
