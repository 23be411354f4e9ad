#include "rt/physics/border_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tactus::physics {
namespace {

template <class T>
const Body<T>* find_by_id(std::span<const Body<T>> bodies, BodyId id) noexcept {
  const auto at =
      std::lower_bound(bodies.begin(), bodies.end(), id, [](const Body<T>& b, BodyId i) { return b.id < i; });
  return at != bodies.end() && at->id == id ? &*at : nullptr;
}

}  // namespace

template <class T>
void BorderSolver<T>::prepare(std::span<BorderContact<T>> contacts, BorderMode mode, std::span<const Body<T>> bodies,
                              SolverBodies<T> solver_bodies, T h, T impulse_scale, bool friction) noexcept {
  mode_ = mode;
  h_ = h;
  rows_.resize(static_cast<std::uint32_t>(contacts.size()));
  pairs_.clear();
  for (std::uint32_t k = 0; k < rows_.size(); ++k) {
    BorderContact<T>& c = contacts[k];
    Row& row = rows_[k];
    row = {};
    const bool same_pair = k > 0 && contacts[k - 1].member == c.member && contacts[k - 1].outside == c.outside;
    if (!same_pair) (void)pairs_.try_push({});
    row.pair = pairs_.size() - 1;
    pairs_[row.pair].cap += c.impulse_rate * h;
    c.step_normal_impulse = T(0), c.step_tangent_impulse = {};
    const Body<T>* member = find_by_id(bodies, c.member);
    if (member == nullptr) continue;
    row.slot = static_cast<std::uint32_t>(member - bodies.data());
    const T mass = solver_bodies.motion[row.slot].inverse_mass;
    if (mass == T(0)) continue;  // frozen: nothing moves it
    row.active = true;
    row.holds = friction && !c.friction_free;
    row.n = c.normal;
    const auto [t1, t2] = tangents_of(row.n);
    row.t1 = t1, row.t2 = t2;
    row.r = rotate(member->motion.pose.rotation, c.member_anchor);
    row.offset = member->motion.pose.position + row.r - c.line_point;
    row.neighbour_velocity = mode == BorderMode::kCapped ? c.outside_velocity : Vec3<T>{};
    row.cap = c.impulse_rate * h;
    row.gap = c.gap;
    row.friction = c.friction;
    const SymMat3<T>& inertia = solver_bodies.inverse_inertia[row.slot];
    row.normal_mass = invert_or_zero(inverse_effective_mass(mass, inertia, row.r, row.n, row.n));
    row.tangent_mass = tangent_mass_of(inverse_effective_mass(mass, inertia, row.r, t1, t1),
                                       inverse_effective_mass(mass, inertia, row.r, t2, t2),
                                       inverse_effective_mass(mass, inertia, row.r, t1, t2));
    const T scale = impulse_scale != T(1) ? impulse_scale : T(1);
    row.normal_impulse = scale * c.normal_impulse;
    if (row.holds)
      row.tangent_impulse[0] = scale * c.tangent_impulse[0], row.tangent_impulse[1] = scale * c.tangent_impulse[1];
  }
  // A pair that the other world found touching without pressing may not push: its rows would cost and do nothing.
  if (mode == BorderMode::kFrozen) return;
  for (Row& row : rows_)
    if (pairs_[row.pair].cap == T(0)) row.active = false;
}

// The most that the normal row may push in a sub-step: what the pair's other points leave of its cap.
template <class T>
T BorderSolver<T>::normal_limit(const Row& row) const noexcept {
  if (mode_ == BorderMode::kFrozen) return std::numeric_limits<T>::max();
  const Pair& pair = pairs_[row.pair];
  return std::max(T(0), pair.cap - (pair.sum - row.normal_impulse));
}

template <class T>
T BorderSolver<T>::gap_at(const Row& row, const SolverBody<T>& body, T elapsed) const noexcept {
  const Vec3<T> off =
      row.offset + body.delta_position + rotate(body.delta_rotation, row.r) - row.r - elapsed * row.neighbour_velocity;
  return row.gap + dot(row.n, off);
}

// The normal row, by the rules of an inner contact: apart, it lets the gap close; overlapping, it pushes out softly in
// the biased sweep and stops the approach in the relax sweep.
template <class T>
void BorderSolver<T>::press(Row& row, SolverBody<T>& body, const SymMat3<T>& inertia, const SweepRule<T>& rule,
                            bool biased) noexcept {
  const T gap = gap_at(row, body, biased ? row.elapsed : row.elapsed + h_);
  Softness<T> soft = Softness<T>::rigid();
  T bias{};
  if (gap > T(0)) {
    bias = gap * rule.inverse_h;
  } else if (biased) {
    soft = rule.softness;
    bias = std::max(soft.mass_scale * soft.bias_rate * std::min(T(0), gap + rule.slop), -rule.max_push_speed);
  }
  const T u = dot(row.n, velocity_at(body, row.r) - row.neighbour_velocity);
  const T wanted =
      row.normal_impulse - row.normal_mass * (soft.mass_scale * u + bias) - soft.impulse_scale * row.normal_impulse;
  const T next = std::clamp(wanted, T(0), normal_limit(row));
  apply_impulse_at(body, inertia, row.r, (next - row.normal_impulse) * row.n);
  pairs_[row.pair].sum += next - row.normal_impulse;
  row.normal_impulse = next;
}

template <class T>
void BorderSolver<T>::begin_sub_step(std::uint32_t j, SolverBodies<T> bodies) noexcept {
  for (Row& row : rows_) {
    if (!row.active) continue;
    const SolverBody<T>& body = bodies.motion[row.slot];
    row.start_velocity = velocity_at(body, row.r);
    row.elapsed = static_cast<T>(j) * h_;
    const Vec3<T> off = row.offset + body.delta_position + rotate(body.delta_rotation, row.r) - row.r -
                        row.elapsed * row.neighbour_velocity;
    row.error[0] = dot(row.t1, off), row.error[1] = dot(row.t2, off);
  }
}

template <class T>
void BorderSolver<T>::apply_replay(SolverBodies<T> bodies) noexcept {
  if (mode_ != BorderMode::kReplay) return;
  for (Row& row : rows_) {
    if (!row.active) continue;
    row.normal_impulse = row.cap;
    apply_impulse_at(bodies.motion[row.slot], bodies.inverse_inertia[row.slot], row.r, row.cap * row.n);
  }
}

template <class T>
void BorderSolver<T>::warm_start(SolverBodies<T> bodies) noexcept {
  for (Pair& pair : pairs_) pair.sum = T(0);
  for (Row& row : rows_) {
    if (!row.active) continue;
    Vec3<T> impulse;
    if (mode_ != BorderMode::kReplay) {
      const T wanted = row.normal_impulse;
      row.normal_impulse = T(0);
      row.normal_impulse = std::clamp(wanted, T(0), normal_limit(row));
      pairs_[row.pair].sum += row.normal_impulse;
      impulse = row.normal_impulse * row.n;
    }
    clamp_to_disk(row.tangent_impulse[0], row.tangent_impulse[1], row.friction * row.normal_impulse);
    row.demand[0] = row.tangent_impulse[0], row.demand[1] = row.tangent_impulse[1];
    impulse += row.tangent_impulse[0] * row.t1 + row.tangent_impulse[1] * row.t2;
    apply_impulse_at(bodies.motion[row.slot], bodies.inverse_inertia[row.slot], row.r, impulse);
  }
}

template <class T>
void BorderSolver<T>::solve(SolverBodies<T> bodies, const SweepRule<T>& rule, bool biased) noexcept {
  const Softness<T> soft = biased ? rule.softness : Softness<T>::rigid();
  for (Row& row : rows_) {
    if (!row.active) continue;
    SolverBody<T>& body = bodies.motion[row.slot];
    const SymMat3<T>& inertia = bodies.inverse_inertia[row.slot];
    if (mode_ != BorderMode::kReplay) press(row, body, inertia, rule, biased);
    if (!row.holds) continue;
    const Vec3<T> u = velocity_at(body, row.r) - row.neighbour_velocity;
    T next[2];
    for (int i = 0; i < 2; ++i) {
      const T bias =
          std::clamp(soft.mass_scale * soft.bias_rate * row.error[i], -rule.max_push_speed, rule.max_push_speed);
      const T slip = dot(i == 0 ? row.t1 : row.t2, u);
      next[i] = row.tangent_impulse[i] - row.tangent_mass * (soft.mass_scale * slip + bias) -
                soft.impulse_scale * row.tangent_impulse[i];
      row.demand[i] = next[i];
    }
    clamp_to_disk(next[0], next[1], row.friction * row.normal_impulse);
    const Vec3<T> change = (next[0] - row.tangent_impulse[0]) * row.t1 + (next[1] - row.tangent_impulse[1]) * row.t2;
    apply_impulse_at(body, inertia, row.r, change);
    row.tangent_impulse[0] = next[0], row.tangent_impulse[1] = next[1];
  }
}

template <class T>
void BorderSolver<T>::end_sub_step(SolverBodies<T> bodies) noexcept {
  for (Row& row : rows_) {
    if (!row.active) continue;
    const Vec3<T> tangential = row.tangent_impulse[0] * row.t1 + row.tangent_impulse[1] * row.t2;
    // Kinetic energy changes by the impulse times the mean of the velocities before and after, exactly.
    row.work += dot(row.normal_impulse * row.n + tangential,
                    T(0.5) * (row.start_velocity + velocity_at(bodies.motion[row.slot], row.r)));
    row.step_normal += row.normal_impulse;
    row.step_tangent += tangential;
    row.step_demand[0] += row.demand[0], row.step_demand[1] += row.demand[1];
  }
}

template <class T>
void BorderSolver<T>::scale_impulses(T factor) noexcept {
  for (Pair& pair : pairs_) pair.sum *= factor;
  for (Row& row : rows_) {
    if (mode_ != BorderMode::kReplay) row.normal_impulse *= factor;
    row.tangent_impulse[0] *= factor, row.tangent_impulse[1] *= factor;
    row.demand[0] *= factor, row.demand[1] *= factor;
  }
}

template <class T>
void BorderSolver<T>::store_impulses(std::span<BorderContact<T>> contacts, T share) const noexcept {
  for (std::uint32_t k = 0; k < rows_.size(); ++k) {
    const auto blend = [share](T& to, T from) noexcept { to = share == T(1) ? from : to + share * (from - to); };
    blend(contacts[k].normal_impulse, rows_[k].normal_impulse);
    for (int d = 0; d < 2; ++d) blend(contacts[k].tangent_impulse[d], rows_[k].tangent_impulse[d]);
  }
}

template <class T>
void BorderSolver<T>::store(std::span<BorderContact<T>> contacts, T dt, T share) const noexcept {
  store_impulses(contacts, share);
  for (std::uint32_t k = 0; k < rows_.size(); ++k) {
    const Row& row = rows_[k];
    BorderContact<T>& c = contacts[k];
    if (mode_ == BorderMode::kCapped) c.line_point += dt * c.outside_velocity;
    c.step_normal_impulse = row.step_normal, c.step_tangent_impulse = row.step_tangent;
    c.total_normal_impulse += row.step_normal, c.total_tangent_impulse += row.step_tangent;
    c.work += row.work;
    const T limit = row.friction * row.step_normal;
    const T demand_squared = row.step_demand[0] * row.step_demand[0] + row.step_demand[1] * row.step_demand[1];
    if (row.holds && demand_squared > limit * limit) {
      c.friction_free = true;
      c.tangent_impulse[0] = c.tangent_impulse[1] = T(0);
    }
  }
}

template class BorderSolver<double>;
template class BorderSolver<float>;

}  // namespace tactus::physics
