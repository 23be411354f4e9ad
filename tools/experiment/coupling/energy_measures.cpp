#include "tools/experiment/coupling/energy_measures.h"

#include <algorithm>

namespace tactus::experiment {
namespace {

// Kinetic energy below this share of the spring's energy is treated as vibration at rest.
constexpr double kMoves = 0.1;

}  // namespace

void EnergyDeviation::Sums::close() {
  lost += std::max(0.0, reference - now);
  won += std::max(0.0, now - reference);
  all_reference += reference;
  now = reference = 0;
}

void EnergyDeviation::Sums::add(const Sums& other) {
  lost += other.lost;
  won += other.won;
  all_reference += other.all_reference;
}

void EnergyDeviation::add(const EnergySample& motion, const EnergySample& reference, double spring_J) {
  spring_J_ += spring_J;
  most_spring_J_ = std::max(most_spring_J_, spring_J);
  kinetic_.now += motion.kinetic_J;
  kinetic_.reference += reference.kinetic_J;
  speed_.now += motion.speed_squared;
  speed_.reference += reference.speed_squared;
  most_lost_J_ = std::max(most_lost_J_, reference.kinetic_J - motion.kinetic_J);
  most_won_J_ = std::max(most_won_J_, motion.kinetic_J - reference.kinetic_J);
  most_reference_J_ = std::max(most_reference_J_, reference.kinetic_J);
}

void EnergyDeviation::close_window() {
  kinetic_.close();
  speed_.close();
}

void EnergyDeviation::add(const EnergyDeviation& other) {
  kinetic_.add(other.kinetic_);
  speed_.add(other.speed_);
  most_lost_J_ = std::max(most_lost_J_, other.most_lost_J_);
  most_won_J_ = std::max(most_won_J_, other.most_won_J_);
  most_reference_J_ = std::max(most_reference_J_, other.most_reference_J_);
  spring_J_ += other.spring_J_;
  most_spring_J_ = std::max(most_spring_J_, other.most_spring_J_);
}

Deviation EnergyDeviation::share(const Sums& sums) {
  if (!(sums.all_reference > 0)) return {};
  return {sums.lost / sums.all_reference, sums.won / sums.all_reference};
}

bool EnergyDeviation::at_rest() const { return kinetic_.all_reference < kMoves * spring_J_; }

Deviation EnergyDeviation::kinetic() const {
  Sums sums = kinetic_;
  if (at_rest()) sums.all_reference += spring_J_;
  return share(sums);
}

Deviation EnergyDeviation::worst_instant() const {
  const double most_J = most_reference_J_ + (at_rest() ? most_spring_J_ : 0);
  if (!(most_J > 0)) return {};
  return {most_lost_J_ / most_J, most_won_J_ / most_J};
}

}  // namespace tactus::experiment
