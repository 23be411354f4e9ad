// Checks that a scene can run with the options of its global world.
#include <fmt/format.h>

#include <algorithm>

#include "sim/global_world.h"
#include "sim/model/world_capacities.h"

namespace tactus::sim {

using physics::BodyKind;

namespace {

// True if a joint connects two bodies of which the border may separate one from the other.
bool may_cut_a_joint(const Scene& scene, std::uint32_t members) {
  if (capacities_for(scene).bodies <= members) return false;
  const auto is_dynamic = [&scene](BodyId id) {
    return id < scene.bodies.size() && scene.bodies[id].kind == BodyKind::kDynamic;
  };
  return std::any_of(scene.effect_data.joints.begin(), scene.effect_data.joints.end(),
                     [&](const auto& joint) { return is_dynamic(joint.a) && is_dynamic(joint.b); });
}

}  // namespace

Status check_global_options(const Scene& scene, const GlobalOptions& options) {
  const haptics::CouplingTraits coupling = traits_of(options.coupling);
  if (!coupling.global_world)
    return Status::error("direct coupling runs the whole world at the haptic rate: it has no global world");
  if (options.reach.ratio == 0 || !(options.reach.tick_period_s > 0))
    return Status::error("the ratio must be 1 or more, and the tick period above 0 s");
  if (!(scene.solver.global_sub_steps_per_tick > 0))
    return Status::error("solver.global_sub_steps_per_tick is 0: give 0.1 or more");
  if (scene.proxy >= scene.bodies.size() || scene.bodies[scene.proxy].kind != BodyKind::kDynamic)
    return Status::error("the scene's proxy must be one of its dynamic bodies");
  if (coupling.proxy_alone() && !options.more_devices.empty())
    return Status::error("this coupling holds one proxy: use sub-world with several devices");
  if (options.extraction.all_members && !options.more_devices.empty())
    return Status::error(
        "every body was asked to be a member, but there are several devices, and a body is a member of one");
  if (options.more_devices.size() >= kMaxHands)
    return Status::error(
        fmt::format("{} devices asked for: 1 to {} are possible", options.more_devices.size() + 1, kMaxHands));
  for (const FurtherDevice& device : options.more_devices)
    if (device.proxy >= scene.bodies.size() || device.proxy == scene.proxy ||
        scene.bodies[device.proxy].kind != BodyKind::kDynamic)
      return Status::error(fmt::format("body {} is no proxy for a further device: it must be dynamic", device.proxy));
  if (options.extraction.cap == 0 || options.extraction.cap > haptics::kMaxMembers)
    return Status::error(
        fmt::format("{} members asked for: 1 to {} are possible", options.extraction.cap, haptics::kMaxMembers));
  const std::uint32_t bodies = capacities_for(scene).bodies;
  if (options.extraction.all_members && bodies > haptics::kMaxMembers)
    return Status::error(
        fmt::format("every body was asked to be a member, but the scene has {} moving bodies and a "
                    "sub-world holds {}",
                    bodies, haptics::kMaxMembers));
  // On the other side of a joint those borders have a body of infinite mass that moves as it last did: the return of
  // the joint's impulses then adds energy, and the bodies fly apart (tests/border/pendulum_cut.toml).
  const physics::BorderTraits border = traits_of(options.border_mode);
  if (coupling.border && !border.ghosts && may_cut_a_joint(scene, options.extraction.cap))
    return Status::error(fmt::format(
        "border {}: joints connect bodies that may end on both sides of it, and only ghosts answer through a "
        "joint; choose the border ghost, or {} members, as many as bodies move",
        border.name, bodies));
  return Status::good();
}

}  // namespace tactus::sim
