// Energy lost and gained by a coupling, by three definitions, because the paper says only "based on the velocity of the
// bodies".
//
//   L1 = 1 - sum E / sum E_ref            kinetic energy of all bodies, translation and rotation
//   L2 = max (E_ref - E) / max E_ref      the worst instant
//   L3 = 1 - sum |v|^2 / sum |v_ref|^2    speeds alone
//
// A scene at rest has no kinetic energy to compare with; there L1 and L2 are shares of the reference energy: E_ref plus
// the energy of the coupling's spring. Loss and gain are summed separately over windows, so that a gain in
// one window cannot hide a loss in another. The sums weight each window by its energy. Thread: [any].
#pragma once

#include "tools/experiment/coupling/coupled_worlds.h"

namespace tactus::experiment {

struct Deviation {
  double loss{0}, gain{0};  // fractions, both 0 or more
};

class EnergyDeviation {
 public:
  // At one instant. `spring_J`: energy of the coupling's spring in the reference.
  void add(const EnergySample& motion, const EnergySample& reference, double spring_J);
  void close_window();

  bool at_rest() const;                                      // the reference has too little kinetic energy to divide by
  Deviation kinetic() const;                                 // L1
  Deviation worst_instant() const;                           // L2
  Deviation speed_squared() const { return share(speed_); }  // L3
  void add(const EnergyDeviation& other);

 private:
  struct Sums {
    double now{0}, reference{0};               // of the window
    double lost{0}, won{0}, all_reference{0};  // of the windows closed
    void close();
    void add(const Sums& other);
  };
  static Deviation share(const Sums& sums);

  Sums kinetic_, speed_;
  double most_lost_J_{0}, most_won_J_{0}, most_reference_J_{0};
  double spring_J_{0}, most_spring_J_{0};  // sum over all instants; maximum
};

}  // namespace tactus::experiment
