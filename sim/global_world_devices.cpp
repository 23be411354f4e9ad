// The devices of a global world: how each holds its proxy, and which sub-world a body belongs to.
//
// A body that two proxies hold is a member of one sub-world only. The loop of that sub-world simulates it without
// delay; in the other loop it is an outside body, some two cycles late. The loops exchange states and momentum, never
// spring forces: the spring of each coupling acts in one loop only. The sub-world of a body is decided by contacts with
// the proxies, not by influence, so that a body between two hands does not alternate between the sub-worlds:
//   - a body belongs to the first sub-world that takes it, the lower device first;
//   - it remains a member there while it touches that proxy, whatever else it touches;
//   - once it has not touched that proxy for linger_cycles and touches another one, it leaves and may join the other.
// Bodies that joints connect count as one: they touch a proxy if one of them does. These rules depend on the contacts
// of the global world alone, in the order of devices and bodies, so the same reports give the same members.
#include "sim/global_world.h"

namespace tactus::sim {

using haptics::SubWorldReport;

// Without a prediction the hand goes on at its velocity: the bound on the interpolated coupling's gains is for such a
// hand (interpolation_limit.h), and the other borders do not correct what the global step gets wrong.
void GlobalWorld::take_hand(Device& device, const SubWorldReport& report) noexcept {
  const bool sane = is_finite(report.device.pose) && is_finite(report.device.velocity);
  const double cycle_s = predicts() ? report.ticks * device.reach.tick_period_s : 0.0;
  device.hand.take(sane ? report.device : haptics::DeviceTarget{}, cycle_s);
}

// Sets the coupling's spring and damper between each proxy and its device, for a macro step of `macro_step_s` that
// begins `elapsed_s` after the start of the step; the device is extrapolated, and moves through the macro step at its
// velocity in the middle. With the sub-world coupling the proxy in the global world then pushes its contacts as the
// proxy in the sub-world will; with a force held over the step the two would drift apart. A device that is not engaged
// brings the proxy to rest. The other couplings hold a wrench (impose).
void GlobalWorld::hold_proxy(double elapsed_s, double macro_step_s) noexcept {
  if (coupling_.device_load != haptics::DeviceLoad::kSpring) return;
  for (std::uint32_t d = 0; d < devices_.size(); ++d) {
    haptics::DeviceTarget ahead = devices_[d].hand.after(elapsed_s);
    ahead.velocity = devices_[d].hand.velocity_after(elapsed_s + 0.5 * macro_step_s);
    const physics::SlotIndex slot = slot_of(devices_[d]);
    physics::PoseSpring spring;
    haptics::aim_spring(devices_[d].gains, ahead, slot, world_.body(slot).motion.pose, spring);
    world_.device_spring(d) = spring;
  }
}

// Clears target and wrenches of a device without a report: those that it sent last are too old to act on the proxy.
void GlobalWorld::leave_out(Device& device) noexcept {
  device.hand = {};
  device.device_wrench = {};
  device.last_device_wrench = {};
}

void GlobalWorld::build_graph() noexcept {
  graph_.build(static_cast<std::uint32_t>(islands_.bodies().size()), touches_);
  if (devices_.size() == 1) return;
  for (Device& device : devices_) note_touched_bodies(device);
}

// Updates `apart`, the steps since each body last touched the proxy. A body that joints connect to a touching body
// counts as touching.
void GlobalWorld::note_touched_bodies(Device& device) noexcept {
  for (const BodyIndex body : device.apart.indices())
    if (device.apart[body] < kLongApart) ++device.apart[body];
  touched_bodies_.clear();
  const auto hold = [&](BodyIndex body) noexcept {
    const bool is_proxy = std::any_of(devices_.begin(), devices_.end(),
                                      [body](const Device& other) noexcept { return other.proxy == body; });
    if (is_proxy || device.apart[body] == 0) return;
    device.apart[body] = 0;
    touched_bodies_.push_back(body);
  };
  for (const ContactGraph::Link& link : graph_.links(device.proxy)) hold(link.body);
  for (std::size_t head = 0; head < touched_bodies_.size(); ++head)
    for (const ContactGraph::Link& link : graph_.links(touched_bodies_[head]))
      if (graph_.touches()[link.touch].joined) hold(link.body);
}

bool GlobalWorld::must_leave(const Device& device, BodyIndex body) const noexcept {
  if (device.apart[body] <= options_.extraction.linger_cycles) return false;
  return std::any_of(devices_.begin(), devices_.end(),
                     [&](const Device& other) noexcept { return &other != &device && other.apart[body] == 0; });
}

// Sets free_ to 0 for the other devices' proxies and members, and for members of this device that must leave; to 1 for
// all others.
void GlobalWorld::find_free_bodies(const Device& device) noexcept {
  free_.fill(1);
  if (devices_.size() == 1) return;
  for (const Device& other : devices_) {
    if (&other == &device) continue;
    free_[other.proxy] = 0;
    for (const BodyIndex member : other.extraction.members()) free_[member] = 0;
  }
  for (const BodyIndex member : device.extraction.members()) {
    if (member == device.proxy || !must_leave(device, member)) continue;
    free_[member] = 0;
    ++statistics_.handed_over;
  }
}

}  // namespace tactus::sim
