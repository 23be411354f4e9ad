#include "rt/physics/effects/attraction.h"

#include "rt/physics/body_search.h"

namespace tactus::physics {

void Attraction::pull(StageContext& c) noexcept {
  const auto place_of = [&](std::uint32_t i) noexcept {
    return c.bodies[i].motion.pose.position + c.motion[i].delta_position;
  };
  for (const AttractionSource& source : setup_.sources) {
    Vec3d from = source.position_m;
    std::uint32_t source_slot = kNoSlot;
    if (source.body != kNoBody) {
      const std::uint32_t fixed = find_slot(c.fixed_bodies, source.body);
      source_slot = find_slot(c.bodies, source.body);
      if (fixed == kNoSlot && source_slot == kNoSlot) continue;
      from = fixed != kNoSlot ? c.fixed_bodies[fixed].motion.pose.position : place_of(source_slot);
    }
    Vec3d sum;
    for (std::uint32_t i = 0; i < c.motion.size(); ++i) {
      const BodyId id = c.bodies[i].id;
      if (i == source_slot || c.frozen[i] != 0 || id >= setup_.weight_by_id.size()) continue;
      const Vec3d d = from - place_of(i);
      const double square = norm_squared(d) + source.softening_m * source.softening_m;
      const double strength = source.strength_Nm2 * setup_.weight_by_id[id] / (square * std::sqrt(square));
      c.motion[i].v += (c.h * c.motion[i].inverse_mass * strength) * d;
      sum += strength * d;
    }
    if (source_slot != kNoSlot) c.motion[source_slot].v -= (c.h * c.motion[source_slot].inverse_mass) * sum;
  }
}

}  // namespace tactus::physics
