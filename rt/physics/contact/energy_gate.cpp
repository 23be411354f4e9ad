#include "rt/physics/contact/energy_gate.h"

namespace tactus::physics {

template <class T>
void EnergyGate<T>::begin_islands(std::uint32_t bodies) noexcept {
  parent_.resize(bodies), islands_.resize(bodies), share_.resize(bodies);
  for (std::uint32_t slot = 0; slot < bodies; ++slot) parent_[slot] = slot;
  knows_islands_ = true;
}

template <class T>
void EnergyGate<T>::link(const SolverBodies<T>& bodies, std::uint32_t slot_a, std::uint32_t slot_b) noexcept {
  if (bodies.motion[slot_a].inverse_mass == T(0) || bodies.motion[slot_b].inverse_mass == T(0)) return;
  const std::uint32_t a = island_of(slot_a), b = island_of(slot_b);
  parent_[std::max(a, b)] = std::min(a, b);
}

template <class T>
bool EnergyGate<T>::hold_back(SolverBodies<T> bodies, std::span<Twist<T>> given, T blow_m_per_s) noexcept {
  for (Island& island : islands_) island = {};
  for (std::uint32_t i = 0; i < given.size(); ++i) {
    if (bodies.motion[i].inverse_mass == T(0)) continue;
    Island& island = islands_[island_of(i)];
    const T added = island.change.add(bodies.motion[i], bodies.inverse_inertia[i], given[i]);
    if (norm_squared(given[i].linear) > blow_m_per_s * blow_m_per_s) island.blow += added;
  }
  bool held_back = false;
  for (std::uint32_t i = 0; i < given.size(); ++i) {
    const Island& island = islands_[island_of(i)];
    const bool blow = island.blow > T(0.5) * island.change.quadratic;
    const T share = share_[i] = blow ? island.change.best_share() : T(1);
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
