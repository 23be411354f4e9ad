// Energy lost and won by a coupling, in three readings: the paper says "based on the velocity of the bodies" and no
// more.
//
//   L1 = 1 - sum E / sum E_ref            kinetic energy of all bodies, translation and rotation
//   L2 = max (E_ref - E) / max E_ref      the worst instant
//   L3 = 1 - sum |v|^2 / sum |v_ref|^2    speeds alone
//
// A scene at rest has no kinetic energy to compare with: there L1 and L2 are shares of the energy at play, E_ref and
// what the coupling's spring holds. Loss and gain apart, window by window, so that a window that won does not hide one
// that lost. Sums over windows weigh each by its energy: what hardly moves counts little. Thread: [any].
#pragma once

#include "tools/experiment/coupling/coupled_worlds.h"

namespace tactus::experiment {

struct Deviation {
  double loss{0}, gain{0};  // fractions, both 0 or more
};

class EnergyBook {
 public:
  // At one instant. `spring_J`: what the coupling's spring holds in the reference.
  void add(const EnergySample& motion, const EnergySample& reference, double spring_J);
  void close_window();

  bool at_rest() const;                                      // the reference moves too little for shares of it
  Deviation kinetic() const;                                 // L1
  Deviation worst_instant() const;                           // L2
  Deviation speed_squared() const { return share(speed_); }  // L3
  void add(const EnergyBook& other);

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
  double spring_J_{0}, most_spring_J_{0};  // over all instants; the most of one
};

}  // namespace tactus::experiment
