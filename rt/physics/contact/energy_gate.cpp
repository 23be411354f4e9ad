#include "rt/physics/contact/energy_gate.h"

namespace tactus::physics {

template <class T>
void EnergyGate<T>::begin_islands(std::uint32_t bodies) noexcept {
  parents_.resize(bodies);
  change_.resize(bodies);
  share_.resize(bodies);
  islands_ = Islands(parents_.span());
  knows_islands_ = true;
}

template <class T>
void EnergyGate<T>::link(const SolverBodies<T>& bodies, std::uint32_t slot_a, std::uint32_t slot_b) noexcept {
  if (bodies.motion[slot_a].inverse_mass > T(0) && bodies.motion[slot_b].inverse_mass > T(0))
    islands_.link(slot_a, slot_b);
}

template <class T>
bool EnergyGate<T>::hold_back(SolverBodies<T> bodies, std::span<Twist<T>> given, T impact_m_per_s) noexcept {
  const bool has_impact = std::any_of(
      given.begin(), given.end(), [&](const Twist<T>& change) noexcept { return is_impact(change, impact_m_per_s); });
  if (!has_impact) return false;
  // Whether an impact dominates its island is mostly decided without the inertia of the other bodies, at a tenth of the
  // work.
  for (IslandChange& change : change_) change = {};
  const auto moves = [&](std::uint32_t i) noexcept { return bodies.motion[i].inverse_mass > T(0); };
  for (std::uint32_t i = 0; i < given.size(); ++i) {
    if (!moves(i)) continue;
    IslandChange& change = change_[islands_.of(i)];
    change.shift += dot((T(1) / bodies.motion[i].inverse_mass) * given[i].linear, given[i].linear);
    if (!is_impact(given[i], impact_m_per_s)) continue;
    EnergyChange<T> own;
    own.add(bodies.motion[i], bodies.inverse_inertia[i], given[i]);
    change.impact += own.quadratic;
  }
  if (std::none_of(change_.begin(), change_.end(), [](const IslandChange& c) noexcept { return c.may_be_impact(); }))
    return false;
  for (std::uint32_t i = 0; i < given.size(); ++i)
    if (IslandChange& change = change_[islands_.of(i)]; moves(i) && change.may_be_impact())
      change.all.add(bodies.motion[i], bodies.inverse_inertia[i], given[i]);
  bool held_back = false;
  for (std::uint32_t i = 0; i < given.size(); ++i) {
    const IslandChange& change = change_[islands_.of(i)];
    const bool impact = change.may_be_impact() && change.is_impact();
    const T share = share_[i] = impact ? change.all.best_share() : T(1);
    if (share == T(1)) continue;
    held_back = true;
    bodies.motion[i].v -= (T(1) - share) * given[i].linear;
    bodies.motion[i].w -= (T(1) - share) * given[i].angular;
    given[i] *= share;
  }
  return held_back;
}

template class EnergyGate<double>;
template class EnergyGate<float>;

}  // namespace tactus::physics
