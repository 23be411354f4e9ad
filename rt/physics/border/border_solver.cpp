#include "rt/physics/border/border_solver.h"

#include <algorithm>
#include <limits>

namespace tactus::physics {

// Limit of the normal impulse in a sub-step: what the pair's other points leave of its cap.
double BorderSolver::normal_limit(const Row& row) const noexcept {
  if (!rule_.limited) return std::numeric_limits<double>::max();
  const Pair& pair = pairs_[row.pair];
  return std::max(0.0, pair.cap - (pair.sum - row.normal_impulse));
}

// What the surface of a ball moved at the point since the start of the step because it turned [m]: along the
// tangents only.
Vec3d BorderSolver::rolled_at(const Row& row, const SolverBody<double>& body) noexcept {
  return row.round > 0.0 ? -row.round * cross(small_rotation_vector(body.delta_rotation), row.n) : Vec3d{};
}

// Offset of the member's point from line_point as moved by the outside body, `elapsed` into the step.
Vec3d BorderSolver::offset_at(const Row& row, double elapsed) noexcept {
  return row.ghost == kNoGhost ? row.offset - elapsed * row.outside_velocity : row.offset;
}

void BorderSolver::find_offsets(SolverBodies<double> bodies) noexcept {
  for (Row& row : rows_) {
    if (!row.active) continue;
    const SolverBody<double>& body = bodies.motion[row.slot];
    row.offset = row.start_offset + body.delta_position + rotate(body.delta_rotation, row.centre) - row.centre +
                 rolled_at(row, body);
    if (row.ghost == kNoGhost) continue;
    const GhostState& ghost = ghosts_[row.ghost];
    row.offset = row.offset - ghost.moved - cross(ghost.turned, row.ghost_r);
  }
}

// Relative velocity of the member's point. With nothing available an approaching ghost counts as at rest along the
// normal.
Vec3d BorderSolver::slip(const Row& row, const SolverBody<double>& body) const noexcept {
  if (row.ghost == kNoGhost) return velocity_at(body, row.r) - row.outside_velocity;
  const Twistd& ghost = ghosts_[row.ghost].velocity;
  const Vec3d v = ghost.linear + cross(ghost.angular, row.ghost_r);
  return velocity_at(body, row.r) - (may_supply_ ? v : v - std::max(0.0, dot(row.n, v)) * row.n);
}

// Applies impulses along n, t1 and t2 to the member, and the opposite to the ghost.
void BorderSolver::apply_impulse(const Row& row, SolverBody<double>& body, const SymMat3d& inertia, double normal,
                                 double tangent1, double tangent2) noexcept {
  apply_impulse_at(body, inertia, row.r, normal * row.n + tangent1 * row.t1 + tangent2 * row.t2);
  if (row.ghost == kNoGhost) return;
  Twistd& ghost = ghosts_[row.ghost].velocity;
  const double by[3] = {normal, tangent1, tangent2};
  for (int i = 0; i < 3; ++i) ghost += by[i] * row.ghost_answer[i];
}

// The same along n alone, and along t1 and t2: what a sweep applies.
void BorderSolver::apply_normal(const Row& row, SolverBody<double>& body, const SymMat3d& inertia,
                                double normal) noexcept {
  if (normal == 0.0) return;
  apply_impulse_at(body, inertia, row.r, normal * row.n);
  if (row.ghost != kNoGhost) ghosts_[row.ghost].velocity += normal * row.ghost_answer[0];
}

void BorderSolver::apply_tangents(const Row& row, SolverBody<double>& body, const SymMat3d& inertia, double tangent1,
                                  double tangent2) noexcept {
  if (tangent1 == 0.0 && tangent2 == 0.0) return;
  apply_impulse_at(body, inertia, row.r, tangent1 * row.t1 + tangent2 * row.t2);
  if (row.ghost == kNoGhost) return;
  Twistd& ghost = ghosts_[row.ghost].velocity;
  ghost += tangent1 * row.ghost_answer[1];
  ghost += tangent2 * row.ghost_answer[2];
}

// Solves the normal row by the rules of an inner contact: while separated, it lets the gap close; overlapping, it
// corrects the overlap softly in the biased sweep and stops the approach in the relax sweep.
void BorderSolver::solve_normal(Row& row, SolverBody<double>& body, const SymMat3d& inertia,
                                const SweepRule<double>& rule, bool biased) noexcept {
  const double gap = row.gap + dot(row.n, offset_at(row, biased ? row.elapsed : row.elapsed + h_));
  Softness<double> soft = Softness<double>::rigid();
  double bias{}, leak{};
  if (gap > 0.0) {
    bias = gap * rule.inverse_h;
  } else if (biased && may_supply_) {  // otherwise rigid: no overlap is corrected, no impulse relaxed
    soft = row.softness;
    const Correction<double> correction = limited<double>(
        {soft.mass_scale * soft.bias_rate * std::min(0.0, gap + rule.slop), soft.impulse_scale * row.normal_impulse},
        row.normal_mass, -row.max_push_speed);
    bias = correction.push;
    leak = correction.leak;
  }
  const double u = dot(row.n, slip(row, body));
  const double wanted = row.normal_impulse - row.normal_mass * (soft.mass_scale * u + bias) - leak;
  const double next = std::clamp(wanted, 0.0, normal_limit(row));
  apply_normal(row, body, inertia, next - row.normal_impulse);
  pairs_[row.pair].sum += next - row.normal_impulse;
  row.normal_impulse = next;
}

void BorderSolver::begin_sub_step(std::uint32_t j, SolverBodies<double> bodies) noexcept {
  for (GhostState& ghost : ghosts_) {
    ghost.velocity += h_ * ghost.drive;
    ghost.before = ghost.velocity;
  }
  if (j == 0) find_offsets(bodies);
  for (Row& row : rows_) {
    if (!row.active) continue;
    row.start_velocity = velocity_at(bodies.motion[row.slot], row.r);
    row.elapsed = static_cast<double>(j) * h_;
    if (row.ghost != kNoGhost) continue;
    const Vec3d off = offset_at(row, row.elapsed);
    row.error[0] = dot(row.t1, off);
    row.error[1] = dot(row.t2, off);
  }
}

void BorderSolver::apply_replay(SolverBodies<double> bodies) noexcept {
  if (!rule_.replays) return;
  for (Row& row : rows_) {
    if (!row.active) continue;
    SolverBody<double>& body = bodies.motion[row.slot];
    row.normal_impulse = row.cap;
    if (!may_supply_) {
      // J (v + v') / 2 = 0, v before the sub-step and v' after it; v' is the present velocity plus J / m.
      const double no_work = -row.normal_mass * dot(row.n, row.start_velocity + velocity_at(body, row.r));
      row.normal_impulse = std::clamp(no_work, 0.0, row.cap);
    }
    apply_impulse_at(body, bodies.inverse_inertia[row.slot], row.r, row.normal_impulse * row.n);
  }
}

void BorderSolver::warm_start(SolverBodies<double> bodies) noexcept {
  for (Pair& pair : pairs_) pair.sum = 0.0;
  for (Row& row : rows_) {
    if (!row.active) continue;
    double normal{};
    if (!rule_.replays) {
      const double wanted = row.normal_impulse;
      row.normal_impulse = 0.0;
      row.normal_impulse = std::clamp(wanted, 0.0, normal_limit(row));
      pairs_[row.pair].sum += row.normal_impulse;
      normal = row.normal_impulse;
    }
    clamp_to_disk(row.tangent_impulse[0], row.tangent_impulse[1], row.friction * row.normal_impulse);
    row.demand[0] = row.tangent_impulse[0];
    row.demand[1] = row.tangent_impulse[1];
    if (row.presses())
      apply_impulse(row, bodies.motion[row.slot], bodies.inverse_inertia[row.slot], normal, row.tangent_impulse[0],
                    row.tangent_impulse[1]);
  }
}

// Solves friction as for an inner contact.
void BorderSolver::solve_friction(Row& row, SolverBody<double>& body, const SymMat3d& inertia) noexcept {
  if (!row.presses()) return;  // a disk of radius 0
  const Vec3d u = slip(row, body);
  double next[2] = {row.tangent_impulse[0] - row.tangent_mass * dot(row.t1, u),
                    row.tangent_impulse[1] - row.tangent_mass * dot(row.t2, u)};
  clamp_to_disk(next[0], next[1], row.friction * row.normal_impulse);
  apply_tangents(row, body, inertia, next[0] - row.tangent_impulse[0], next[1] - row.tangent_impulse[1]);
  row.tangent_impulse[0] = next[0];
  row.tangent_impulse[1] = next[1];
}

void BorderSolver::solve_friction_point(Row& row, SolverBody<double>& body, const SymMat3d& inertia,
                                        const SweepRule<double>& rule, bool biased) noexcept {
  const Softness<double> soft = biased ? rule.softness : Softness<double>::rigid();
  const Vec3d u = slip(row, body);
  double next[2];
  for (int i = 0; i < 2; ++i) {
    const double pull =
        std::clamp(soft.mass_scale * soft.bias_rate * row.error[i], -rule.max_push_speed, rule.max_push_speed);
    const double bias = may_supply_ ? pull : 0.0;
    const double along = dot(i == 0 ? row.t1 : row.t2, u);
    next[i] = row.tangent_impulse[i] - row.tangent_mass * (soft.mass_scale * along + bias) -
              soft.impulse_scale * row.tangent_impulse[i];
    row.demand[i] = next[i];
  }
  clamp_to_disk(next[0], next[1], row.friction * row.normal_impulse);
  apply_tangents(row, body, inertia, next[0] - row.tangent_impulse[0], next[1] - row.tangent_impulse[1]);
  row.tangent_impulse[0] = next[0];
  row.tangent_impulse[1] = next[1];
}

// Forwards in the biased sweep and backwards in the relax sweep, the iteration is symmetric: its eigenvalues are real
// and in [0, 1) (Saad, Iterative Methods for Sparse Linear Systems, 2003, section 4.1). In one direction only they are
// complex, and the errors of many coupled rows oscillate: the load on a plank of tests/border/crib.toml (shares 14/15)
// oscillated by a third of its mean, and the proxy crept along it. With the symmetric order it oscillates by 4.5 %,
// with the slow rows swept twice by 1.5 %.
void BorderSolver::solve(SolverBodies<double> bodies, const SweepRule<double>& rule, bool biased) noexcept {
  const std::uint32_t count = rows_.size();
  const auto at = [&](std::uint32_t i) noexcept -> Row& { return rows_[biased ? i : count - 1 - i]; };
  for (std::uint32_t i = 0; i < count; ++i) solve_row(at(i), bodies, rule, biased);
  if (biased) return;
  for (std::uint32_t i = 0; i < count; ++i)
    if (at(i).slow) solve_row(at(i), bodies, rule, biased);
}

void BorderSolver::solve_row(Row& row, SolverBodies<double> bodies, const SweepRule<double>& rule,
                             bool biased) noexcept {
  if (!row.active) return;
  SolverBody<double>& body = bodies.motion[row.slot];
  const SymMat3d& inertia = bodies.inverse_inertia[row.slot];
  if (!rule_.replays) solve_normal(row, body, inertia, rule, biased);
  if (!row.holds) return;
  if (row.ghost == kNoGhost)
    solve_friction_point(row, body, inertia, rule, biased);
  else if (!biased)
    solve_friction(row, body, inertia);
}

void BorderSolver::move_ghosts() noexcept {
  for (GhostState& ghost : ghosts_) {
    ghost.moved += h_ * ghost.velocity.linear;
    ghost.turned += h_ * ghost.velocity.angular;
  }
}

Vec3d BorderSolver::impulse_of(const Row& row) const noexcept {
  return row.normal_impulse * row.n + row.tangent_impulse[0] * row.t1 + row.tangent_impulse[1] * row.t2;
}

// The change of kinetic energy is exactly the impulse times the mean of the velocities before and after.
double BorderSolver::work_of(const Row& row, const SolverBody<double>& body) const noexcept {
  return 0.5 * dot(impulse_of(row), row.start_velocity + velocity_at(body, row.r));
}

// Takes back so much of a row's impulse J that the work on the member becomes `allowed` (work_limit.h). The part D is
// the friction; if that is not enough, or if the normal impulse itself supplies energy, all of J.
void BorderSolver::take_back_work(Row& row, SolverBody<double>& body, const SymMat3d& inertia,
                                  double allowed) noexcept {
  const auto take_back = [&](double normal, double tangent) noexcept {
    const Vec3d all = impulse_of(row);
    const Vec3d part = normal * row.normal_impulse * row.n + tangent * (all - row.normal_impulse * row.n);
    const Vec3d mean = 0.5 * (row.start_velocity + velocity_at(body, row.r));
    const double q = inverse_effective_mass(body.inverse_mass, inertia, row.r, part, part);
    const double p = dot(part, mean) + 0.5 * inverse_effective_mass(body.inverse_mass, inertia, row.r, all, part);
    const double beyond = dot(all, mean) - allowed;
    const double x = share_taken_back(p, q, beyond);
    apply_impulse(row, body, inertia, x * normal * row.normal_impulse, x * tangent * row.tangent_impulse[0],
                  x * tangent * row.tangent_impulse[1]);
    row.normal_impulse *= 1.0 + x * normal;
    row.tangent_impulse[0] *= 1.0 + x * tangent;
    row.tangent_impulse[1] *= 1.0 + x * tangent;
  };
  if (row.normal_impulse * dot(row.n, row.start_velocity + velocity_at(body, row.r)) <= 0.0) take_back(0.0, 1.0);
  if (work_of(row, body) > allowed) take_back(1.0, 1.0);
}

// Fills the rows' work in this sub-step.
Works BorderSolver::find_works(SolverBodies<double> bodies) noexcept {
  Works works;
  for (Row& row : rows_) {
    if (!row.active) continue;
    row.sub_step_work = row.presses() ? work_of(row, bodies.motion[row.slot]) : 0.0;
    works.add(row.sub_step_work);
  }
  return works;
}

// Limits the energy that rows put into members to what is left of the available energy. Rows that take energy out are
// not reduced. Leaves the rows' work known.
void BorderSolver::keep_within_tank(SolverBodies<double> bodies) noexcept {
  const double share = share_kept(find_works(bodies), left_J());
  if (!(share < 1.0)) return;
  for (Row& row : rows_) {
    if (!row.active) continue;
    SolverBody<double>& body = bodies.motion[row.slot];
    const double work = work_of(row, body);
    if (work > 0.0) take_back_work(row, body, bodies.inverse_inertia[row.slot], share * work);
  }
  (void)find_works(bodies);
}

void BorderSolver::end_sub_step(SolverBodies<double> bodies) noexcept {
  keep_within_tank(bodies);
  for (Row& row : rows_) {
    if (!row.active) continue;
    row.step_demand[0] += row.demand[0];
    row.step_demand[1] += row.demand[1];
    row.rolled = rolled_at(row, bodies.motion[row.slot]);
    row.turned = bodies.motion[row.slot].delta_rotation;
    if (!row.presses()) continue;
    const Vec3d tangential = row.tangent_impulse[0] * row.t1 + row.tangent_impulse[1] * row.t2;
    row.work += row.sub_step_work;
    available_J_ -= row.sub_step_work;
    row.step_normal += row.normal_impulse;
    row.step_tangent += tangential;
    if (row.ghost == kNoGhost) continue;
    const Vec3d on_ghost = -(row.normal_impulse * row.n + tangential);
    Wrenchd& sum = ghosts_[row.ghost].impulse;
    sum += Wrenchd{on_ghost, cross(row.ghost_r, on_ghost)};
  }
}

void BorderSolver::scale_impulses(double factor) noexcept {
  for (Pair& pair : pairs_) pair.sum *= factor;
  for (GhostState& ghost : ghosts_) {
    const auto scaled = [factor](const Vec3d& from, const Vec3d& to) noexcept { return from + factor * (to - from); };
    ghost.velocity = {scaled(ghost.before.linear, ghost.velocity.linear),
                      scaled(ghost.before.angular, ghost.velocity.angular)};
  }
  for (Row& row : rows_) {
    if (!rule_.replays) row.normal_impulse *= factor;
    row.tangent_impulse[0] *= factor;
    row.tangent_impulse[1] *= factor;
    row.demand[0] *= factor;
    row.demand[1] *= factor;
  }
}

void BorderSolver::store_impulses(std::span<BorderContact> contacts, double share) const noexcept {
  for (std::uint32_t k = 0; k < rows_.size(); ++k) {
    const auto blend = [share](double& to, double from) noexcept {
      to = share == 1.0 ? from : to + share * (from - to);
    };
    blend(contacts[k].normal_impulse, rows_[k].normal_impulse);
    for (int d = 0; d < 2; ++d) blend(contacts[k].tangent_impulse[d], rows_[k].tangent_impulse[d]);
  }
}

// The ghost's ball or cap has moved against the member, and the contact point with it.
void BorderSolver::follow_ghost(const Row& row, const GhostState& ghost, const Vec3d& at,
                                BorderContact& contact) noexcept {
  contact.ghost_centre += cross(ghost.turned, contact.ghost_centre);
  if (contact.member_round > 0.0) return;
  const Vec3d off = at + contact.ghost_centre + row.ghost_round * row.n - contact.line_point;
  const Vec3d along = off - dot(off, row.n) * row.n;
  contact.line_point += along;
  contact.member_anchor += rotate_inverse(row.turned * row.rotation, along);
}

void BorderSolver::store(std::span<BorderContact> contacts, std::span<BorderGhost> ghosts, double dt,
                         double share) const noexcept {
  store_impulses(contacts, share);
  for (std::uint32_t g = 0; g < ghosts_.size(); ++g) {
    const GhostState& from = ghosts_[g];
    ghosts[g].velocity = from.velocity;
    ghosts[g].centre += from.moved;
    ghosts[g].total_impulse += from.impulse;
  }
  for (std::uint32_t k = 0; k < rows_.size(); ++k) {
    const Row& row = rows_[k];
    BorderContact& c = contacts[k];
    if (rule_.surface_moves) c.line_point += dt * c.outside_velocity;
    c.line_point -= row.rolled;
    c.step_normal_impulse = row.step_normal;
    c.step_tangent_impulse = row.step_tangent;
    c.total_normal_impulse += row.step_normal;
    c.total_tangent_impulse += row.step_tangent;
    c.work += row.work;
    if (row.ghost != kNoGhost) {
      const GhostState& ghost = ghosts_[row.ghost];
      c.line_point += row.offset + ghost.moved + cross(ghost.turned, row.ghost_r);
      c.gap = row.gap + dot(row.n, row.offset);
      if (row.ghost_round > 0.0) follow_ghost(row, ghost, ghosts[row.ghost].centre, c);
      continue;
    }
    const double limit = row.friction * row.step_normal;
    const double demand_squared = row.step_demand[0] * row.step_demand[0] + row.step_demand[1] * row.step_demand[1];
    if (row.holds && demand_squared > limit * limit) {
      c.friction_free = true;
      c.tangent_impulse[0] = c.tangent_impulse[1] = 0.0;
    }
  }
}

}  // namespace tactus::physics
