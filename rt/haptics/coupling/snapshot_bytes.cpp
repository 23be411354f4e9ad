#include "rt/haptics/coupling/snapshot_bytes.h"

#include <cmath>
#include <utility>

#include "rt/base/list_bytes.h"

namespace tactus::haptics {
namespace {

bool is_body(const physics::Body& b, const physics::ShapeLists& shapes) noexcept {
  return b.id < physics::kFirstPatchId && b.kind == physics::BodyKind::kDynamic && is_known(b.shape, false, shapes) &&
         is_finite(b.motion.pose) && is_finite(b.motion.velocity) && std::isfinite(b.mass) && b.mass > 0 &&
         is_finite(b.inertia) && b.inertia.x > 0 && b.inertia.y > 0 && b.inertia.z > 0;
}

bool are_near_triangles(const WorldSnapshot& s, physics::Meshes meshes) noexcept {
  const physics::NearRegion* last = nullptr;
  for (const auto& region : s.near_regions) {
    if (region.mesh >= meshes.size() || region.count > s.near_triangles.size() ||
        region.first > s.near_triangles.size() - region.count)
      return false;
    if (last != nullptr && (last->body != region.body ? last->body > region.body : last->mesh >= region.mesh))
      return false;
    last = &region;
    const auto triangles = s.near_triangles.span().subspan(region.first, region.count);
    for (std::size_t i = 0; i < triangles.size(); ++i)
      if (triangles[i] >= meshes[region.mesh].triangles.size() || (i > 0 && triangles[i - 1] >= triangles[i]))
        return false;
  }
  return true;
}

// Checks the preconditions of the sub-world, so that bytes of a damaged tape never reach its asserts.
bool is_sound(const WorldSnapshot& s, const physics::ShapeLists& shapes) noexcept {
  for (std::uint32_t i = 1; i < s.members.size(); ++i)
    if (s.members[i - 1] >= s.members[i]) return false;
  for (const auto& joiner : s.joiners)
    if (!is_body(joiner, shapes)) return false;
  for (const auto& warm_start : s.warm_starts)
    if (warm_start.count > physics::kMaxManifoldPoints) return false;
  for (const MotionCorrection& c : s.corrections)
    if (!is_finite(Posed{c.displacement_m, c.rotation}) || !is_finite(c.velocity) || !(norm(c.rotation) > 0.5))
      return false;
  return std::isfinite(s.border_work_J) && s.outside_motion_J >= 0.0 && std::isfinite(s.outside_motion_J) &&
         are_near_triangles(s, shapes.meshes);
}

}  // namespace

void write_snapshot(ByteWriter& out, const WorldSnapshot& s) noexcept {
  out.put(s.cycle);
  out.put(s.global_time_s);
  out.put(s.dropped);
  out.put(s.component);
  out.put(s.epoch);
  out.put(s.border_work_J);
  out.put(s.outside_motion_J);
  out.put(s.proxy);
  write_list(out, s.members);
  write_list(out, s.joiners);
  write_list(out, s.warm_starts);
  write_list(out, s.corrections);
  write_list(out, s.border);
  write_list(out, s.outside);
  write_list(out, s.near_regions);
  write_list(out, s.near_triangles);
  write_list(out, s.effects);
}

bool read_snapshot(ByteReader& in, WorldSnapshot& s, const physics::ShapeLists& shapes) noexcept {
  in.get(s.cycle);
  in.get(s.global_time_s);
  in.get(s.dropped);
  in.get(s.component);
  in.get(s.epoch);
  in.get(s.border_work_J);
  in.get(s.outside_motion_J);
  in.get(s.proxy);
  return read_list(in, s.members) && read_list(in, s.joiners) && read_list(in, s.warm_starts) &&
         read_list(in, s.corrections) && read_list(in, s.border) && read_list(in, s.outside) &&
         read_list(in, s.near_regions) && read_list(in, s.near_triangles) && read_list(in, s.effects) &&
         is_sound(s, shapes);
}

bool write_effects(const physics::World& world, std::span<const std::uint8_t> inside, EffectBytes& out) noexcept {
  ByteWriter bytes(std::span<std::byte>(out.items));
  world.effects().export_state(bytes, world.bodies(), inside);
  out.count = bytes.ok() ? static_cast<std::uint32_t>(bytes.size()) : 0;
  return bytes.ok();
}

void read_effects(const EffectBytes& in, bool known_too, physics::World& world) noexcept {
  if (in.empty()) return;
  ByteReader bytes(in.span());
  (void)world.effects().import_state(bytes, std::as_const(world).bodies(), known_too);
}

}  // namespace tactus::haptics
