#include "sim/exchange/buffer_choice.h"

#include <algorithm>
#include <limits>

namespace tactus::sim {
namespace {

using physics::Body;

// Inverse mass of a body at the contact point, along the normal [1/kg].
double inverse_mass_at(const Body& body, const ContactEdge& touch) noexcept {
  const Vec3d lever_arm =
      rotate_inverse(body.motion.pose.rotation, cross(touch.point - body.motion.pose.position, touch.normal));
  const auto over = [](double x, double inertia) { return inertia > 0 ? x * x / inertia : 0.0; };
  return 1 / body.mass + over(lever_arm.x, body.inertia.x) + over(lever_arm.y, body.inertia.y) +
         over(lever_arm.z, body.inertia.z);
}

// Inverse mass of an outside body's ghost at the contact point, along the normal [1/kg]; 0, as of static geometry,
// where there is no ghost yet.
double inverse_mass_at(std::span<const haptics::OutsideBody> outside, BodyId id, const ContactEdge& touch) noexcept {
  const auto at =
      std::lower_bound(outside.begin(), outside.end(), id, [](const auto& body, BodyId i) { return body.id < i; });
  if (at == outside.end() || at->id != id) return 0;
  const Vec3d r = touch.point - at->centre;
  const Twistd answer = at->admittance * Wrenchd{touch.normal, cross(r, touch.normal)};
  return dot(touch.normal, answer.linear + cross(answer.angular, r));
}

}  // namespace

std::uint32_t BufferChoice::choose(BodySpan<const Body> bodies, const Extraction& extraction, const ContactGraph& graph,
                                   BodyIndex proxy, const Surroundings& around,
                                   BodySpan<std::uint8_t> in_buffer) noexcept {
  std::fill(in_buffer.begin(), in_buffer.end(), std::uint8_t{0});
  physics::Islands groups(std::span<std::uint32_t>(parent_).first(bodies.size()));
  for (const ContactEdge& touch : graph.touches()) {
    const bool a = extraction.is_member(touch.a), b = extraction.is_member(touch.b);
    if (a != b) in_buffer[a ? touch.a : touch.b] = 1;
    if (a && b && touch.a != proxy && touch.b != proxy) groups.link(number_of(touch.a), number_of(touch.b));
  }
  in_buffer[proxy] = 0;
  for (const BodyIndex member : extraction.members()) shares_[member] = {};
  if (!weigh(bodies, extraction, in_buffer, groups)) return 0;
  find_shares(bodies, extraction, graph, proxy, around);
  if (!weigh(bodies, extraction, in_buffer, groups)) return 0;
  std::uint32_t added = 0;
  for (const BodyIndex member : extraction.members()) {
    if (member == proxy || in_buffer[member] != 0 || !is_uneven(BodyIndex{groups.of(number_of(member))})) continue;
    in_buffer[member] = 1;
    ++added;
  }
  return added;
}

bool BufferChoice::weigh(BodySpan<const Body> bodies, const Extraction& extraction,
                         BodySpan<const std::uint8_t> in_buffer, physics::Islands& groups) noexcept {
  bool any = false;
  for (const BodyIndex member : extraction.members()) {
    const BodyIndex group{groups.of(number_of(member))};
    const double mass = bodies[member].mass;
    // Members ascend, so the group's lowest body comes first and resets its entries.
    if (group == member) {
      lightest_[group] = std::numeric_limits<double>::infinity();
      heaviest_[group] = 0;
    }
    if (group == member) at_border_[group] = 0;
    if (!shares_[member].at_end()) lightest_[group] = std::min(lightest_[group], mass);
    heaviest_[group] = std::max(heaviest_[group], mass);
    if (in_buffer[member] != 0) at_border_[group] = 1;
    any = any || is_uneven(group);
  }
  return any;
}

void BufferChoice::find_shares(BodySpan<const Body> bodies, const Extraction& extraction, const ContactGraph& graph,
                               BodyIndex proxy, const Surroundings& around) noexcept {
  for (const auto& contact : around.contacts)
    if (contact.b_fixed && contact.touching()) shares_[around.awake[contact.slot_a]].other = 1;
  const auto add = [&](const ContactEdge& touch, BodyIndex of, BodyIndex by) noexcept {
    const double own = inverse_mass_at(bodies[of], touch);
    Shares& shares = shares_[of];
    if (!extraction.is_member(by)) {
      const double ghost = inverse_mass_at(around.outside, bodies[by].id, touch);
      shares.other = std::max(shares.other, touch.joined ? 1 : own / (own + ghost));
    } else if (by != proxy) {
      ++shares.links;
      shares.linked = touch.joined ? 1 : own / (own + inverse_mass_at(bodies[by], touch));
    }
  };
  for (const ContactEdge& touch : graph.touches()) {
    if (extraction.is_member(touch.a)) add(touch, touch.a, touch.b);
    if (extraction.is_member(touch.b)) add(touch, touch.b, touch.a);
  }
}

}  // namespace tactus::sim
