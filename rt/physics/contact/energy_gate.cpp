#include "rt/physics/contact/energy_gate.h"

namespace tactus::physics {

template <class T>
void EnergyGate<T>::begin_islands(std::uint32_t bodies) noexcept {
  islands_.begin(bodies), change_.resize(bodies), share_.resize(bodies);
  knows_islands_ = true;
}

template <class T>
void EnergyGate<T>::link(const SolverBodies<T>& bodies, std::uint32_t slot_a, std::uint32_t slot_b) noexcept {
  if (bodies.motion[slot_a].inverse_mass > T(0) && bodies.motion[slot_b].inverse_mass > T(0))
    islands_.link(slot_a, slot_b);
}

template <class T>
bool EnergyGate<T>::hold_back(SolverBodies<T> bodies, std::span<Twist<T>> given, T blow_m_per_s) noexcept {
  for (IslandChange& change : change_) change = {};
  for (std::uint32_t i = 0; i < given.size(); ++i) {
    if (bodies.motion[i].inverse_mass == T(0)) continue;
    IslandChange& change = change_[islands_.of(i)];
    const T added = change.all.add(bodies.motion[i], bodies.inverse_inertia[i], given[i]);
    if (is_blow(given[i], blow_m_per_s)) change.blow += added;
  }
  bool held_back = false;
  for (std::uint32_t i = 0; i < given.size(); ++i) {
    const IslandChange& change = change_[islands_.of(i)];
    const bool blow = change.blow > T(0.5) * change.all.quadratic;
    const T share = share_[i] = blow ? change.all.best_share() : T(1);
    if (share == T(1)) continue;
    held_back = true;
    bodies.motion[i].v -= (T(1) - share) * given[i].linear, bodies.motion[i].w -= (T(1) - share) * given[i].angular;
    given[i].linear *= share, given[i].angular *= share;
  }
  return held_back;
}

template class EnergyGate<double>;
template class EnergyGate<float>;

}  // namespace tactus::physics
