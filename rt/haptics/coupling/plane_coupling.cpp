#include "rt/haptics/coupling/plane_coupling.h"

#include "rt/base/list_bytes.h"

namespace tactus::haptics {

void PlaneCoupling::adopt(std::span<const physics::BorderContact> contacts) noexcept {
  before_ = now_;
  now_.planes.clear();
  now_.held = held_;
  for (const auto& contact : contacts) {
    // With the proxy at x the anchor is x + arm. When the contact point, which is `member_round` below it, was at
    // line_point, its distance to the surface was `gap`.
    const double height = dot(contact.normal, contact.line_point) + contact.member_round - contact.gap;
    if (!now_.planes.try_push({.normal = contact.normal,
                               .anchor = contact.member_anchor,
                               .height = height,
                               .friction = contact.friction,
                               .press_N = contact.impulse_rate,
                               .surface_velocity = contact.outside_velocity}))
      return;
  }
}

void PlaneCoupling::start(const Vec3d& proxy) noexcept {
  now_.planes.clear();
  held_ = now_.held = proxy;
  follows_ = 1;
}

// The planes constrain the position x + lead v only. Then K times the correction is the whole force of spring and
// damper, so the friction cone applies to both:
//   K (x - p) + B (v - v_p)
// Without contact the proxy is at x.
HeldProxy PlaneCoupling::follow(const DeviceTarget& target, const Tick& tick) noexcept {
  if (follows_ == 0) held_ = now_.held = before_.held = target.pose.position + tick.lead_s * target.velocity.linear;
  follows_ = 1;
  HeldProxy held = keep(now_, target, tick);
  if (tick.in_cycle + 1 < tick.ratio) {
    const double share = static_cast<double>(tick.in_cycle + 1) / tick.ratio;
    const HeldProxy old = keep(before_, target, tick);
    held.position = old.position + share * (held.position - old.position);
    held.velocity = old.velocity + share * (held.velocity - old.velocity);
    held.touches = held.touches || old.touches;
    held.slides = held.slides || old.slides;
  }
  held_ = held.position;
  held.position -= tick.lead_s * held.velocity;
  return held;
}

HeldProxy PlaneCoupling::keep(PlaneSet& set, const DeviceTarget& target, const Tick& tick) noexcept {
  const double surface_moves_s = tick.in_cycle < tick.ratio ? tick.period_s : 0.0;
  ProxyPlanes planes;
  for (const ContactPlane& contact : set.planes) {
    if (tick.planes_hold && contact.press_N <= 0) continue;
    const Vec3d arm = rotate(target.pose.rotation, contact.anchor);
    (void)planes.try_push({.normal = contact.normal,
                           .offset = contact.height - dot(contact.normal, arm),
                           .friction = contact.friction,
                           .hold = set.held + surface_moves_s * contact.surface_velocity,
                           .surface_velocity = contact.surface_velocity});
  }
  const Vec3d wanted = target.pose.position + tick.lead_s * target.velocity.linear;
  const HeldProxy held = tick.planes_hold ? keep_on(planes.span(), wanted, target.velocity.linear)
                                          : keep_above(planes.span(), wanted, target.velocity.linear);
  set.held = held.position;
  return held;
}

void PlaneCoupling::save(ByteWriter& out) const noexcept {
  for (const PlaneSet* set : {&now_, &before_}) {
    write_list(out, set->planes);
    out.put(set->held);
  }
  out.put(held_);
  out.put(follows_);
}

bool PlaneCoupling::restore(ByteReader& in) noexcept {
  for (PlaneSet* set : {&now_, &before_}) {
    if (!read_list(in, set->planes)) return false;
    in.get(set->held);
  }
  in.get(held_);
  in.get(follows_);
  return in.ok();
}

}  // namespace tactus::haptics
