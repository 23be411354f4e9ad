#include "rt/physics/border/ghost_solver.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "rt/physics/body_search.h"

namespace tactus::physics {
namespace {

// A member between two ghosts is slow if a sweep leaves more than this share of an error: after the four relax sweeps
// of a tick 10 % is left, with rows swept twice 1 %. Measured range: from 0.2 to 0.85 the force errors of seven whole
// runs (tests/border/README.md) are the same within 0.01 %.
inline constexpr double kSlowShare = 0.5625;

bool is_same_contact(const BorderContact& p, const BorderContact& q) noexcept {
  return p.member == q.member && p.outside == q.outside && p.parts == q.parts && p.normal == q.normal &&
         p.member_round == q.member_round && p.friction == q.friction;
}

void clear_results(BorderContact& c) noexcept {
  c.step_normal_impulse = 0.0;
  c.step_tangent_impulse = {};
}

void clear_impulses(BorderContact& c) noexcept { c.normal_impulse = c.tangent_impulse[0] = c.tangent_impulse[1] = 0.0; }

// The ghost's ball or cap has moved against the member, and the contact point with it.
void follow_ghost(const BorderGhost& ghost, const GhostState& state, const Posed& member,
                  BorderContact& contact) noexcept {
  contact.ghost_centre += cross(state.turned, contact.ghost_centre);
  if (contact.member_round > 0.0) return;
  const Vec3d off = ghost.centre + contact.ghost_centre + contact.ghost_round * contact.normal - contact.line_point;
  const Vec3d along = off - dot(off, contact.normal) * contact.normal;
  contact.line_point += along;
  contact.member_anchor += rotate_inverse(member.rotation, along);
}

}  // namespace

GhostSolver::GhostSolver(const Capacities& capacities)
    : groups_(capacities.border_contacts),
      of_member_(capacities.border_contacts > 0 ? capacities.bodies : 0),
      of_ghost_(capacities.border_contacts),
      rows_(capacities.border_contacts),
      ghosts_(capacities.border_contacts) {}

void GhostSolver::prepare(std::span<BorderContact> contacts, std::span<const BorderGhost> ghosts,
                          std::span<const Body> bodies, SolverBodies<double> solver_bodies,
                          const BorderStep& step) noexcept {
  h_ = step.h;
  const bool has_ghosts = traits_of(step.rule.mode).ghosts;
  ghosts_.resize(has_ghosts ? static_cast<std::uint32_t>(ghosts.size()) : 0);
  for (std::uint32_t g = 0; g < ghosts_.size(); ++g) {
    ghosts_[g] = {};
    ghosts_[g].outside = ghosts[g].outside;
    ghosts_[g].admittance = ghosts[g].admittance;
    ghosts_[g].velocity = ghosts[g].velocity;
    ghosts_[g].drive = ghosts[g].drive;
  }
  find_groups(has_ghosts ? contacts : std::span<BorderContact>{}, bodies, solver_bodies);
  place_groups();
  for (const Group& group : groups_)
    fill_lane(rows_[group.row], static_cast<int>(group.lane),
              {.points = contacts.subspan(group.first, group.count),
               .slot = group.slot,
               .member = bodies[group.slot].motion.pose,
               .ghost = ghosts[group.ghost],
               .impulse_scale = step.impulse_scale,
               .friction = step.friction},
              solver_bodies);
  for (GhostRow& row : rows_) {
    // Empty lanes read the bodies of the first lane and write nothing.
    for (std::uint32_t lane = row.used; lane < kWidth; ++lane) {
      row.member[lane] = row.member[0];
      row.ghost[lane] = row.ghost[0];
    }
    complete(row, step.sweep.softness);
  }
  mark_slow_rows();
}

void GhostSolver::find_groups(std::span<BorderContact> contacts, std::span<const Body> bodies,
                              SolverBodies<double> solver_bodies) noexcept {
  groups_.clear();
  std::uint32_t slot = kNoSlot;
  for (std::uint32_t k = 0, end = 0; k < contacts.size(); k = end) {
    const BorderContact& first = contacts[k];
    clear_results(contacts[k]);
    for (end = k + 1; end < contacts.size() && end - k < kMaxManifoldPoints && is_same_contact(first, contacts[end]);
         ++end)
      clear_results(contacts[end]);
    if (k == 0 || contacts[k - 1].member != first.member) slot = find_slot(bodies, first.member);
    if (slot != kNoSlot && solver_bodies.motion[slot].inverse_mass != 0.0 && first.ghost < ghosts_.size()) {
      (void)groups_.try_push({.first = k, .count = end - k, .slot = slot, .ghost = first.ghost});
    } else {
      for (BorderContact& contact : contacts.subspan(k, end - k)) clear_impulses(contact);
    }
  }
}

// Gives each contact a lane of its colour. A row takes the time of its contact with the most points, so those with as
// many share rows.
void GhostSolver::place_groups() noexcept {
  if (groups_.empty()) return rows_.clear();
  std::uint32_t slots = 0;
  for (const Group& group : groups_) slots = std::max(slots, group.slot + 1);
  of_member_.resize(slots);
  of_ghost_.resize(ghosts_.size());
  for (auto& taken : of_member_) taken = 0;
  for (auto& taken : of_ghost_) taken = 0;
  std::array<std::array<std::uint32_t, kMaxManifoldPoints>, kColours> lane{};  // number of contacts, then the next lane
  std::uint32_t own_rows = 0;
  for (Group& group : groups_) {
    group.colour = static_cast<std::uint32_t>(std::countr_one(of_member_[group.slot] | of_ghost_[group.ghost]));
    if (group.colour == kOwnRow) {
      ++own_rows;
      continue;
    }
    const std::uint64_t bit = std::uint64_t{1} << group.colour;
    of_member_[group.slot] |= bit;
    of_ghost_[group.ghost] |= bit;
    ++lane[group.colour][group.count - 1];
  }
  std::uint32_t row = 0;
  for (auto& of_colour : lane) {
    std::uint32_t next = row * kWidth;
    for (std::uint32_t points = kMaxManifoldPoints; points > 0; --points)
      next += std::exchange(of_colour[points - 1], next);
    row = (next + kWidth - 1) / kWidth;
  }
  const std::uint32_t own = row;
  rows_.resize(own + own_rows);
  for (GhostRow& r : rows_) r.used = 0;
  std::uint32_t next_own = own;
  for (Group& group : groups_) {
    const bool alone = group.colour == kOwnRow;
    const std::uint32_t at = alone ? next_own++ * kWidth : lane[group.colour][group.count - 1]++;
    group.row = at / kWidth;
    group.lane = at % kWidth;
    ++rows_[group.row].used;
  }
  for (GhostRow& r : rows_) {
    const std::uint32_t used = r.used;
    if (used < kWidth) r = {};
    r.used = used;
    r.points = 0;
    r.slow = r.any_round = false;
  }
}

void GhostSolver::mark_slow_rows() noexcept {
  const std::span<const Group> groups = groups_.span();
  for (std::size_t k = 0, end = 0; k < groups.size(); k = end) {
    end = k + 1;
    while (end < groups.size() && groups[end].slot == groups[k].slot) ++end;
    mark_slow_rows(groups.subspan(k, end - k));
  }
}

// The row against one ghost leaves the share w / (w + W) of an error to the member's next row (w: inverse effective
// mass of the member, W: of the ghost); a sweep over two rows leaves the product of their shares.
void GhostSolver::mark_slow_rows(std::span<const Group> of_member) noexcept {
  const auto share = [&](const Group& group) noexcept {
    return lane_of(rows_[group.row].member_share, static_cast<int>(group.lane));
  };
  const Group* most = &of_member[0];
  for (const Group& group : of_member)
    if (share(group) > share(*most)) most = &group;
  double other{};
  for (const Group& group : of_member)
    if (group.ghost != most->ghost) other = std::max(other, share(group));
  if (share(*most) * other > kSlowShare)
    for (const Group& group : of_member) rows_[group.row].slow = true;
}

void GhostSolver::begin_sub_step(SolverBodies<double> bodies) noexcept {
  for (GhostState& ghost : ghosts_) {
    ghost.velocity += h_ * ghost.drive;
    ghost.before = ghost.velocity;
  }
  for (GhostRow& row : rows_) physics::begin_sub_step(row, bodies);
}

void GhostSolver::warm_start(SolverBodies<double> bodies) noexcept {
  for (GhostRow& row : rows_) physics::warm_start(row, bodies, ghosts_.span());
}

void GhostSolver::solve_biased(SolverBodies<double> bodies, const SweepRule<double>& rule, double supply) noexcept {
  for (GhostRow& row : rows_) physics::solve_biased(row, bodies, ghosts_.span(), rule, supply);
}

void GhostSolver::relax(SolverBodies<double> bodies, const SweepRule<double>& rule, double supply, bool last) noexcept {
  const std::span<GhostRow> rows = rows_.span();
  for (std::size_t i = rows.size(); i-- > 0;) physics::relax(rows[i], bodies, ghosts_.span(), rule, supply, last);
  for (std::size_t i = rows.size(); i-- > 0;)
    if (rows[i].slow) physics::relax(rows[i], bodies, ghosts_.span(), rule, supply, last);
}

void GhostSolver::move_ghosts() noexcept {
  for (GhostState& ghost : ghosts_) {
    ghost.moved += h_ * ghost.velocity.linear;
    ghost.turned += h_ * ghost.velocity.angular;
  }
}

void GhostSolver::end_sub_step(SolverBodies<double> bodies, Allowance& allowance) noexcept {
  const auto find_works = [&]() noexcept {
    Works works;
    for (GhostRow& row : rows_) {
      find_work(row, bodies);
      for (std::uint32_t i = 0; i < row.points; ++i)
        for (std::uint32_t lane = 0; lane < row.used; ++lane)
          works.add(lane_of(row.sub_step_work[i], static_cast<int>(lane)));
    }
    return works;
  };
  Works works = find_works();
  if (const double share = share_kept(works, allowance.left_J()); share < 1.0) {
    for (GhostRow& row : rows_) keep_share(row, bodies, ghosts_.span(), share);
    works = find_works();
  }
  for (GhostRow& row : rows_) physics::end_sub_step(row, ghosts_.span());
  allowance.available_J -= works.sum;
}

void GhostSolver::scale_impulses(double factor) noexcept {
  for (GhostState& ghost : ghosts_) ghost.velocity = ghost.before + factor * (ghost.velocity - ghost.before);
  for (GhostRow& row : rows_) physics::scale_impulses(row, factor);
}

void GhostSolver::keep_impulses(std::span<BorderContact> contacts) const noexcept {
  for (const Group& group : groups_)
    store_impulses(rows_[group.row], static_cast<int>(group.lane), 1.0, contacts.subspan(group.first, group.count));
}

void GhostSolver::store(std::span<BorderContact> contacts, std::span<BorderGhost> ghosts, std::span<const Body> bodies,
                        std::span<const SolverBody<double>> motion, double share) const noexcept {
  for (std::uint32_t g = 0; g < ghosts_.size(); ++g) {
    const GhostState& from = ghosts_[g];
    ghosts[g].velocity = from.velocity;
    ghosts[g].centre += from.moved;
    ghosts[g].total_impulse += from.impulse;
  }
  for (const Group& group : groups_) {
    const GhostRow& row = rows_[group.row];
    const auto lane = static_cast<int>(group.lane);
    const std::span<BorderContact> points = contacts.subspan(group.first, group.count);
    store_impulses(row, lane, share, points);
    store_totals(row, lane, points);
    const SolverBody<double>& moved = motion[group.slot];
    const Posed& start = bodies[group.slot].motion.pose;
    const Posed member{start.position + moved.delta_position, moved.delta_rotation * start.rotation};
    for (BorderContact& c : points) {
      c.line_point = c.point_on(member);
      if (c.ghost_round > 0.0) follow_ghost(ghosts[group.ghost], ghosts_[group.ghost], member, c);
    }
  }
}

}  // namespace tactus::physics
