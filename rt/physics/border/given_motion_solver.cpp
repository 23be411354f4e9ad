#include "rt/physics/border/given_motion_solver.h"

#include <algorithm>
#include <limits>

#include "rt/physics/body_search.h"

namespace tactus::physics {

void GivenMotionSolver::prepare(std::span<BorderContact> contacts, std::span<const Body> bodies,
                                SolverBodies<double> solver_bodies, const BorderStep& step) noexcept {
  rule_ = traits_of(step.rule.mode);
  h_ = step.h;
  rows_.resize(rule_.ghosts ? 0 : static_cast<std::uint32_t>(contacts.size()));
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
    row.holds = step.friction && !c.friction_free;
    row.n = c.normal;
    const auto [t1, t2] = tangents_of(row.n);
    row.t1 = t1;
    row.t2 = t2;
    row.centre = rotate(member.rotation, c.member_anchor);
    row.round = c.member_round;
    row.r = row.centre - row.round * row.n;
    row.start_offset = member.position + row.r - c.line_point;
    row.outside_velocity = rule_.surface_moves ? c.outside_velocity : Vec3d{};
    row.cap = c.impulse_rate * step.h;
    row.gap = c.gap;
    row.friction = c.friction;
    const SymMat3d& inertia = solver_bodies.inverse_inertia[row.slot];
    row.normal_mass = invert_or_zero(inverse_effective_mass(mass, inertia, row.r, row.n, row.n));
    row.tangent_mass = tangent_mass_of(inverse_effective_mass(mass, inertia, row.r, t1, t1),
                                       inverse_effective_mass(mass, inertia, row.r, t2, t2),
                                       inverse_effective_mass(mass, inertia, row.r, t1, t2));
    const double scale = step.impulse_scale;
    row.normal_impulse = scale * c.normal_impulse;
    if (row.holds) {
      row.tangent_impulse[0] = scale * c.tangent_impulse[0];
      row.tangent_impulse[1] = scale * c.tangent_impulse[1];
    }
  }
  // A pair that touched without pressing in the other world has a limit of 0: its rows would cost time and do nothing.
  if (!rule_.limited) return;
  for (Row& row : rows_)
    if (pairs_[row.pair].cap == 0.0) row.active = false;
}

// Limit of the normal impulse in a sub-step: what the pair's other points leave of its cap.
double GivenMotionSolver::normal_limit(const Row& row) const noexcept {
  if (!rule_.limited) return std::numeric_limits<double>::max();
  const Pair& pair = pairs_[row.pair];
  return std::max(0.0, pair.cap - (pair.sum - row.normal_impulse));
}

// What the surface of a ball moved at the point since the start of the step because it turned [m]: along the
// tangents only.
Vec3d GivenMotionSolver::rolled_at(const Row& row, const SolverBody<double>& body) noexcept {
  return row.round > 0.0 ? -row.round * cross(small_rotation_vector(body.delta_rotation), row.n) : Vec3d{};
}

void GivenMotionSolver::find_offsets(SolverBodies<double> bodies) noexcept {
  for (Row& row : rows_) {
    if (!row.active) continue;
    const SolverBody<double>& body = bodies.motion[row.slot];
    row.offset = row.start_offset + body.delta_position + rotate(body.delta_rotation, row.centre) - row.centre +
                 rolled_at(row, body);
  }
}

// Solves the normal row by the rules of an inner contact: while separated, it lets the gap close; overlapping, it
// corrects the overlap softly in the biased sweep and stops the approach in the relax sweep.
void GivenMotionSolver::solve_normal(Row& row, SolverBody<double>& body, const SymMat3d& inertia,
                                     const SweepRule<double>& rule, bool biased, bool may_supply) noexcept {
  const double gap = row.gap + dot(row.n, row.offset_at(biased ? row.elapsed : row.elapsed + h_));
  Softness<double> soft = Softness<double>::rigid();
  double bias{}, leak{};
  if (gap > 0.0) {
    bias = gap * rule.inverse_h;
  } else if (biased && may_supply) {  // otherwise rigid: no overlap is corrected, no impulse relaxed
    soft = rule.softness;
    const Correction<double> correction = limited<double>(
        {soft.mass_scale * soft.bias_rate * std::min(0.0, gap + rule.slop), soft.impulse_scale * row.normal_impulse},
        row.normal_mass, -rule.max_push_speed);
    bias = correction.push;
    leak = correction.leak;
  }
  const double u = dot(row.n, row.slip(body));
  const double wanted = row.normal_impulse - row.normal_mass * (soft.mass_scale * u + bias) - leak;
  const double next = std::clamp(wanted, 0.0, normal_limit(row));
  if (next != row.normal_impulse) apply_impulse_at(body, inertia, row.r, (next - row.normal_impulse) * row.n);
  pairs_[row.pair].sum += next - row.normal_impulse;
  row.normal_impulse = next;
}

void GivenMotionSolver::begin_sub_step(std::uint32_t j, SolverBodies<double> bodies) noexcept {
  if (j == 0) find_offsets(bodies);
  for (Row& row : rows_) {
    if (!row.active) continue;
    row.start_velocity = velocity_at(bodies.motion[row.slot], row.r);
    row.elapsed = static_cast<double>(j) * h_;
    const Vec3d off = row.offset_at(row.elapsed);
    row.error[0] = dot(row.t1, off);
    row.error[1] = dot(row.t2, off);
  }
}

void GivenMotionSolver::apply_replay(SolverBodies<double> bodies, bool may_supply) noexcept {
  if (!rule_.replays) return;
  for (Row& row : rows_) {
    if (!row.active) continue;
    SolverBody<double>& body = bodies.motion[row.slot];
    row.normal_impulse = row.cap;
    if (!may_supply) {
      // J (v + v') / 2 = 0, v before the sub-step and v' after it; v' is the present velocity plus J / m.
      const double no_work = -row.normal_mass * dot(row.n, row.start_velocity + velocity_at(body, row.r));
      row.normal_impulse = std::clamp(no_work, 0.0, row.cap);
    }
    apply_impulse_at(body, bodies.inverse_inertia[row.slot], row.r, row.normal_impulse * row.n);
  }
}

void GivenMotionSolver::warm_start(SolverBodies<double> bodies) noexcept {
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
      apply_impulse_at(bodies.motion[row.slot], bodies.inverse_inertia[row.slot], row.r,
                       normal * row.n + row.tangent_impulse[0] * row.t1 + row.tangent_impulse[1] * row.t2);
  }
}

void GivenMotionSolver::solve_friction_point(Row& row, SolverBody<double>& body, const SymMat3d& inertia,
                                             const SweepRule<double>& rule, bool biased, bool may_supply) noexcept {
  const Softness<double> soft = biased ? rule.softness : Softness<double>::rigid();
  const Vec3d u = row.slip(body);
  double next[2];
  for (int i = 0; i < 2; ++i) {
    const double pull =
        std::clamp(soft.mass_scale * soft.bias_rate * row.error[i], -rule.max_push_speed, rule.max_push_speed);
    const double bias = may_supply ? pull : 0.0;
    const double along = dot(i == 0 ? row.t1 : row.t2, u);
    next[i] = row.tangent_impulse[i] - row.tangent_mass * (soft.mass_scale * along + bias) -
              soft.impulse_scale * row.tangent_impulse[i];
    row.demand[i] = next[i];
  }
  clamp_to_disk(next[0], next[1], row.friction * row.normal_impulse);
  const double change_1 = next[0] - row.tangent_impulse[0], change_2 = next[1] - row.tangent_impulse[1];
  if (change_1 != 0.0 || change_2 != 0.0) apply_impulse_at(body, inertia, row.r, change_1 * row.t1 + change_2 * row.t2);
  row.tangent_impulse[0] = next[0];
  row.tangent_impulse[1] = next[1];
}

// Forwards in the biased sweep and backwards in the relax sweep.
void GivenMotionSolver::solve(SolverBodies<double> bodies, const SweepRule<double>& rule, bool biased,
                              bool may_supply) noexcept {
  const std::uint32_t count = rows_.size();
  for (std::uint32_t i = 0; i < count; ++i) {
    Row& row = rows_[biased ? i : count - 1 - i];
    if (!row.active) continue;
    SolverBody<double>& body = bodies.motion[row.slot];
    const SymMat3d& inertia = bodies.inverse_inertia[row.slot];
    if (!rule_.replays) solve_normal(row, body, inertia, rule, biased, may_supply);
    if (row.holds) solve_friction_point(row, body, inertia, rule, biased, may_supply);
  }
}

// Takes back so much of a row's impulse J that the work on the member becomes `allowed` (work_limit.h). The part D is
// the friction; if that is not enough, or if the normal impulse itself supplies energy, all of J.
void GivenMotionSolver::take_back_work(Row& row, SolverBody<double>& body, const SymMat3d& inertia,
                                       double allowed) noexcept {
  const auto take_back = [&](double normal, double tangent) noexcept {
    const Vec3d all = row.impulse();
    const Vec3d part = normal * row.normal_impulse * row.n + tangent * (all - row.normal_impulse * row.n);
    const Vec3d mean = 0.5 * (row.start_velocity + velocity_at(body, row.r));
    const double q = inverse_effective_mass(body.inverse_mass, inertia, row.r, part, part);
    const double p = dot(part, mean) + 0.5 * inverse_effective_mass(body.inverse_mass, inertia, row.r, all, part);
    const double beyond = dot(all, mean) - allowed;
    const double x = share_taken_back(p, q, beyond);
    const Vec3d taken = x * normal * row.normal_impulse * row.n + x * tangent * row.tangent_impulse[0] * row.t1 +
                        x * tangent * row.tangent_impulse[1] * row.t2;
    apply_impulse_at(body, inertia, row.r, taken);
    row.normal_impulse *= 1.0 + x * normal;
    row.tangent_impulse[0] *= 1.0 + x * tangent;
    row.tangent_impulse[1] *= 1.0 + x * tangent;
  };
  if (row.normal_impulse * dot(row.n, row.start_velocity + velocity_at(body, row.r)) <= 0.0) take_back(0.0, 1.0);
  if (row.work_on(body) > allowed) take_back(1.0, 1.0);
}

// Fills the rows' work in this sub-step.
Works GivenMotionSolver::find_works(SolverBodies<double> bodies) noexcept {
  Works works;
  for (Row& row : rows_) {
    if (!row.active) continue;
    row.sub_step_work = row.presses() ? row.work_on(bodies.motion[row.slot]) : 0.0;
    works.add(row.sub_step_work);
  }
  return works;
}

// Leaves the rows' work known.
void GivenMotionSolver::keep_within_tank(SolverBodies<double> bodies, double left_J) noexcept {
  const double share = share_kept(find_works(bodies), left_J);
  if (!(share < 1.0)) return;
  for (Row& row : rows_) {
    if (!row.active) continue;
    SolverBody<double>& body = bodies.motion[row.slot];
    const double work = row.work_on(body);
    if (work > 0.0) take_back_work(row, body, bodies.inverse_inertia[row.slot], share * work);
  }
  (void)find_works(bodies);
}

void GivenMotionSolver::end_sub_step(SolverBodies<double> bodies, Allowance& allowance) noexcept {
  keep_within_tank(bodies, allowance.left_J());
  for (Row& row : rows_) {
    if (!row.active) continue;
    row.step_demand[0] += row.demand[0];
    row.step_demand[1] += row.demand[1];
    row.rolled = rolled_at(row, bodies.motion[row.slot]);
    if (!row.presses()) continue;
    row.work += row.sub_step_work;
    allowance.available_J -= row.sub_step_work;
    row.step_normal += row.normal_impulse;
    row.step_tangent += row.tangent_impulse[0] * row.t1 + row.tangent_impulse[1] * row.t2;
  }
}

void GivenMotionSolver::scale_impulses(double factor) noexcept {
  for (Pair& pair : pairs_) pair.sum *= factor;
  for (Row& row : rows_) {
    if (!rule_.replays) row.normal_impulse *= factor;
    row.tangent_impulse[0] *= factor;
    row.tangent_impulse[1] *= factor;
    row.demand[0] *= factor;
    row.demand[1] *= factor;
  }
}

void GivenMotionSolver::store_impulses(std::span<BorderContact> contacts, double share) const noexcept {
  for (std::uint32_t k = 0; k < rows_.size(); ++k) {
    store_impulse(contacts[k].normal_impulse, rows_[k].normal_impulse, share);
    for (int d = 0; d < 2; ++d) store_impulse(contacts[k].tangent_impulse[d], rows_[k].tangent_impulse[d], share);
  }
}

void GivenMotionSolver::store(std::span<BorderContact> contacts, double dt, double share) const noexcept {
  store_impulses(contacts, share);
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
    const double limit = row.friction * row.step_normal;
    const double demand_squared = row.step_demand[0] * row.step_demand[0] + row.step_demand[1] * row.step_demand[1];
    if (row.holds && demand_squared > limit * limit) {
      c.friction_free = true;
      c.tangent_impulse[0] = c.tangent_impulse[1] = 0.0;
    }
  }
}

}  // namespace tactus::physics
