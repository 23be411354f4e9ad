// The rows of a border, filled at the start of a step.
#include <algorithm>

#include "rt/physics/body_search.h"
#include "rt/physics/border/border_solver.h"

namespace tactus::physics {
namespace {

// A member between two ghosts is slow if a sweep leaves more than this share of an error: after the four relax sweeps
// of a tick 10 % is left, with rows swept twice 1 %. Measured range: from 0.2 to 0.85 the force errors of seven whole
// runs (tests/border/README.md) are the same within 0.01 %.
inline constexpr double kSlowShare = 0.5625;

}  // namespace

void BorderSolver::prepare(std::span<BorderContact> contacts, std::span<const BorderGhost> ghosts,
                           std::span<const Body> bodies, SolverBodies<double> solver_bodies,
                           const BorderStep& step) noexcept {
  rule_ = traits_of(step.rule.mode);
  available_J_ = step.rule.available_J;
  h_ = step.h;
  ghosts_.resize(rule_.ghosts ? static_cast<std::uint32_t>(ghosts.size()) : 0);
  for (std::uint32_t g = 0; g < ghosts_.size(); ++g) {
    ghosts_[g] = {};
    ghosts_[g].outside = ghosts[g].outside;
    ghosts_[g].admittance = ghosts[g].admittance;
    ghosts_[g].velocity = ghosts[g].velocity;
    ghosts_[g].drive = ghosts[g].drive;
  }
  rows_.resize(static_cast<std::uint32_t>(contacts.size()));
  pairs_.clear();
  for (std::uint32_t k = 0; k < rows_.size(); ++k) {
    BorderContact& c = contacts[k];
    Row& row = rows_[k];
    row = {};
    const bool same_pair = k > 0 && contacts[k - 1].member == c.member && contacts[k - 1].outside == c.outside;
    if (!same_pair) (void)pairs_.try_push({});
    row.pair = pairs_.size() - 1;
    pairs_[row.pair].cap += c.impulse_rate * step.h;
    c.step_normal_impulse = 0.0;
    c.step_tangent_impulse = {};
    const std::uint32_t slot = find_slot(bodies, c.member);
    if (slot == kNoSlot) continue;
    row.slot = slot;
    const Posed& member = bodies[slot].motion.pose;
    const double mass = solver_bodies.motion[row.slot].inverse_mass;
    if (mass == 0.0) continue;  // frozen
    row.active = true;
    row.holds = step.friction && (rule_.ghosts || !c.friction_free);
    row.n = c.normal;
    const auto [t1, t2] = tangents_of(row.n);
    row.t1 = t1;
    row.t2 = t2;
    row.rotation = member.rotation;
    row.centre = rotate(member.rotation, c.member_anchor);
    row.round = c.member_round;
    row.r = row.centre - row.round * row.n;
    row.start_offset = member.position + row.r - c.line_point;
    row.outside_velocity = rule_.surface_moves ? c.outside_velocity : Vec3d{};
    row.cap = c.impulse_rate * step.h;
    row.gap = c.gap;
    row.friction = c.friction;
    row.softness = step.sweep.softness;
    row.max_push_speed = step.sweep.max_push_speed;
    const SymMat3d& inertia = solver_bodies.inverse_inertia[row.slot];
    if (rule_.ghosts && c.ghost < ghosts_.size()) {
      init_ghost_row(row, c, ghosts[c.ghost], mass, inertia, member.position + row.r);
    } else if (rule_.ghosts) {
      row.active = false;
    } else {
      row.normal_mass = invert_or_zero(inverse_effective_mass(mass, inertia, row.r, row.n, row.n));
      row.tangent_mass = tangent_mass_of(inverse_effective_mass(mass, inertia, row.r, t1, t1),
                                         inverse_effective_mass(mass, inertia, row.r, t2, t2),
                                         inverse_effective_mass(mass, inertia, row.r, t1, t2));
    }
    const double scale = step.impulse_scale;
    row.normal_impulse = scale * c.normal_impulse;
    if (row.holds) {
      row.tangent_impulse[0] = scale * c.tangent_impulse[0];
      row.tangent_impulse[1] = scale * c.tangent_impulse[1];
    }
  }
  for (std::uint32_t k = 0, end = 0; k < rows_.size(); k = end) {
    end = k + 1;
    while (end < rows_.size() && rows_[end].slot == rows_[k].slot) ++end;
    mark_slow(rows_.span().subspan(k, end - k));
  }
  // A pair that touched without pressing in the other world has a limit of 0: its rows would cost time and do nothing.
  if (!rule_.limited) return;
  for (Row& row : rows_)
    if (pairs_[row.pair].cap == 0.0) row.active = false;
}

// The row against one ghost leaves the share w / (w + W) of an error to the member's next row (w: inverse effective
// mass of the member, W: of the ghost); a sweep over two rows leaves the product of their shares.
void BorderSolver::mark_slow(std::span<Row> of_member) noexcept {
  const Row* most = &of_member[0];
  for (const Row& row : of_member)
    if (row.member_share > most->member_share) most = &row;
  double other{};
  for (const Row& row : of_member)
    if (row.ghost != most->ghost) other = std::max(other, row.member_share);
  for (Row& row : of_member) row.slow = most->member_share * other > kSlowShare;
}

// Fills the effective masses of a row against a ghost: both sides move.
void BorderSolver::init_ghost_row(Row& row, const BorderContact& contact, const BorderGhost& ghost, double inverse_mass,
                                  const SymMat3d& inertia, const Vec3d& point) noexcept {
  row.ghost = contact.ghost;
  row.ghost_round = contact.ghost_round;
  row.ghost_r = row.ghost_round > 0.0 ? contact.ghost_centre + row.ghost_round * row.n : Vec3d{point - ghost.centre};
  const Vec3d* directions[3] = {&row.n, &row.t1, &row.t2};
  for (int i = 0; i < 3; ++i) {
    const Vec3d& d = *directions[i];
    row.ghost_answer[i] = ghost.admittance * Wrenchd{-d, -cross(row.ghost_r, d)};
  }
  const auto answer = [&](int i, const Vec3d& d) noexcept {
    return -dot(d, row.ghost_answer[i].linear + cross(row.ghost_answer[i].angular, row.ghost_r));
  };
  const auto member = [&](const Vec3d& d, const Vec3d& e) noexcept {
    return inverse_effective_mass(inverse_mass, inertia, row.r, d, e);
  };
  const double alone = member(row.n, row.n), both = alone + answer(0, row.n);
  row.normal_mass = invert_or_zero(both);
  row.member_share = alone * row.normal_mass;
  // The compliance is that of the two bodies alone (border_solver.h); a deep overlap pushes with the same force in both
  // worlds.
  const double own_share = (alone + contact.outside_inverse_mass) * row.normal_mass;
  const Softness<double> of_contact = row.softness;
  row.softness.mass_scale = 1.0 / (1.0 + own_share * of_contact.impulse_scale / of_contact.mass_scale);
  row.softness.impulse_scale = 1.0 - row.softness.mass_scale;
  row.max_push_speed = row.max_push_speed * row.softness.mass_scale / of_contact.mass_scale;
  row.tangent_mass =
      tangent_mass_of(member(row.t1, row.t1) + answer(1, row.t1), member(row.t2, row.t2) + answer(2, row.t2),
                      member(row.t1, row.t2) + answer(1, row.t2));
}

}  // namespace tactus::physics
