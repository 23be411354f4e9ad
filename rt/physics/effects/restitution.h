// Effect restitution: what hits fast enough bounces.
//
// Before the sweeps of a sub-step, over the contacts with a coefficient e > 0: the points that come together faster
// than kLeastSpeed and would meet within two sub-steps part at e times that speed (Newton), e the larger of the two
// bodies': the relax sweep already brakes what would pass in the next sub-step. Gravity's work over the gap that is
// left is put right: they part as they would at this gap after a blow at none. The points of one contact answer
// together, one contact after the other hands a blow on, through the list to and fro until nothing strikes any more: so
// a row of balls passes it from end to end. What presses (wrenches, the device) comes later in the sub-step and is no
// blow: it would make resting bodies bounce. No blow ever adds kinetic energy: where the points of a contact have not
// come to agree, it is held back. It is no force to start the next sub-step with. Units: SI. Thread: construction
// [setup]; the rest [rt], the owner of the World. Bound: kMostRounds times the points of contacts with e > 0, each
// sub-step.
#pragma once

#include "rt/physics/effects/stage.h"

namespace tactus::physics {

class Restitution : public Stateless {
 public:
  static constexpr double kLeastSpeed = 0.05;  // m/s: slower contacts would only make resting ones jitter
  static constexpr int kMostRounds = 8;        // through the list, in turns from either end

  struct Setup {
    std::span<const double> by_id{};  // e by body id; those beyond the end have 0. Must outlive the world
    bool used() const noexcept { return !by_id.empty(); }
  };
  Restitution(const Setup& setup, const Capacities& capacities) : by_id_(setup.by_id), rows_(capacities.contacts) {}
  void enter(StageTable& table) noexcept;

 private:
  struct Row {
    std::uint32_t contact{0};
    double coefficient{};
    std::array<double, kMaxManifoldPoints> given{};  // N s, by point, in this step
  };
  struct Strike {
    std::uint32_t point{0};
    double speed{};  // m/s, at which it comes
    double after{};  // m/s, at which it is to part
    double mass{};
    double impulse{};  // N s
  };
  using Strikes = FixedVector<Strike, kMaxManifoldPoints>;

  double coefficient_of(BodyId id) const noexcept { return id < by_id_.size() ? by_id_[id] : 0.0; }
  void list(StageContext& c) noexcept;
  void bounce(StageContext& c) noexcept;
  bool bounce_off(StageContext& c, Row& row) noexcept;  // did anything strike?
  void finish(StageContext& c) noexcept;

  std::span<const double> by_id_;
  BoundedVector<Row> rows_;  // by contact
};

}  // namespace tactus::physics
