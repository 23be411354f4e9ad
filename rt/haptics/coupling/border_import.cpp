#include "rt/haptics/coupling/border_import.h"

namespace tactus::haptics {
namespace {

using physics::BorderContact;
using physics::BorderGhost;

// Window, in contacts, in which a border contact's predecessor is searched. A contact whose predecessor is outside of
// the window starts with zero impulses, which costs a sweep.
constexpr std::uint32_t kSearchWindow = 32;

// Adds a ghost for each outside body, with the motion at the end of the global step.
void renew_ghosts(const WorldSnapshot& snapshot, BoundedVector<BorderGhost>& ghosts) noexcept {
  for (const OutsideBody& body : snapshot.outside) {
    BorderGhost ghost;
    ghost.outside = body.id;
    ghost.centre = body.centre;
    ghost.velocity = body.velocity;
    ghost.admittance = body.admittance;
    ghost.drive = body.drive;
    if (!ghosts.try_push(ghost)) return;
  }
}

BorderContact contact_at(const BorderPoint& point, const Posed& member) noexcept {
  BorderContact contact;
  contact.member = point.member;
  contact.outside = point.outside;
  contact.feature = point.feature;
  contact.parts = point.parts;
  contact.normal = point.normal;
  contact.member_anchor = point.member_anchor;
  contact.impulse_rate = point.impulse_rate_N;
  contact.friction = point.friction;
  contact.outside_velocity = point.outside_velocity;
  contact.outside_inverse_mass = point.outside_inverse_mass;
  contact.member_round = point.member_round_m;
  contact.line_point = contact.point_on(member);
  contact.gap = point.separation_m + dot(point.normal, contact.line_point - point.outside_point);
  return contact;
}

// Starts with the impulses of the global step, means over its sub-steps (border_correction.h).
void start_as_global(const BorderPoint& point, double sub_step_s, BorderContact& contact) noexcept {
  const auto [t1, t2] = tangents_of(point.normal);
  contact.normal_impulse = point.impulse_rate_N * sub_step_s;
  contact.tangent_impulse[0] = dot(point.friction_N, t1) * sub_step_s;
  contact.tangent_impulse[1] = dot(point.friction_N, t2) * sub_step_s;
}

}  // namespace

void BorderImport::keep_impulses(std::span<const BorderContact> contacts) noexcept {
  former_.clear();
  for (const BorderContact& c : contacts)
    (void)former_.try_push({.member = c.member,
                            .outside = c.outside,
                            .feature = c.feature,
                            .parts = c.parts,
                            .normal_impulse = c.normal_impulse,
                            .tangent_impulse = {c.tangent_impulse[0], c.tangent_impulse[1]}});
}

// Copies the impulses that the same point had before the synchronisation. Both lists are in the global world's order,
// so the search starts at `hint`, the entry after the last match.
void BorderImport::continue_from_former(std::uint32_t& hint, BorderContact& contact) const noexcept {
  const std::uint32_t count = former_.size();
  for (std::uint32_t i = 0; i < std::min(kSearchWindow, count); ++i) {
    const std::uint32_t at = (hint + i) % count;
    const Former& old = former_[at];
    if (old.member != contact.member || old.outside != contact.outside || old.feature != contact.feature ||
        old.parts != contact.parts)
      continue;
    contact.normal_impulse = old.normal_impulse;
    contact.tangent_impulse[0] = old.tangent_impulse[0];
    contact.tangent_impulse[1] = old.tangent_impulse[1];
    hint = at + 1;
    return;
  }
}

void BorderImport::renew(const WorldSnapshot& snapshot, const physics::BorderTraits& traits, double sub_step_s,
                         physics::World& world) noexcept {
  auto& contacts = world.border_contacts();
  auto& ghosts = world.border_ghosts();
  keep_impulses(contacts.span());
  contacts.clear();
  ghosts.clear();
  outside_velocity_.clear();
  if (traits.ghosts) renew_ghosts(snapshot, ghosts);
  std::uint32_t hint = 0;
  const physics::Body* member = nullptr;
  std::uint32_t ghost = physics::kNoGhost;
  for (const BorderPoint& point : snapshot.border) {
    if (member == nullptr || member->id != point.member) member = world.find(point.member);
    if (member == nullptr) continue;
    BorderContact contact = contact_at(point, member->motion.pose);
    if (traits.ghosts && point.impulse_rate_N > 0)
      start_as_global(point, sub_step_s, contact);
    else
      continue_from_former(hint, contact);
    if (traits.ghosts) {
      if (ghost == physics::kNoGhost || ghosts[ghost].outside != point.outside)
        ghost = physics::find_ghost(ghosts.span(), point.outside);
      contact.ghost = ghost;
    }
    if (contact.ghost != physics::kNoGhost && point.outside_round_m > 0.0) {
      contact.ghost_round = point.outside_round_m;
      contact.ghost_centre = point.outside_point - point.outside_round_m * point.normal - ghosts[contact.ghost].centre;
    }
    // The world counts what does not fit, and the next step reports it.
    if (world.add_border_contact(contact)) (void)outside_velocity_.try_push(point.outside_velocity);
  }
}

void BorderImport::slow_down(const WorldLateness& late, physics::World& world) const noexcept {
  auto& contacts = world.border_contacts();
  for (std::uint32_t i = 0; i < contacts.size(); ++i)
    contacts[i].outside_velocity = late.surface_share * outside_velocity_[i];
  if (late.ticks == 0) return;
  for (BorderGhost& ghost : world.border_ghosts()) {
    ghost.velocity = {late.ghost_share * ghost.velocity.linear, late.ghost_share * ghost.velocity.angular};
    ghost.drive = {late.ghost_share * ghost.drive.linear, late.ghost_share * ghost.drive.angular};
  }
}

void BorderImport::save(ByteWriter& out) const noexcept {
  out.put(outside_velocity_.size());
  out.put_all(outside_velocity_.span());
}

bool BorderImport::restore(ByteReader& in, const physics::World& world) noexcept {
  std::uint32_t count = 0;
  in.get(count);
  if (!in.ok() || count != world.border_contacts().size()) return false;
  outside_velocity_.resize(count);
  in.get_all(outside_velocity_.span());
  return in.ok();
}

}  // namespace tactus::haptics
