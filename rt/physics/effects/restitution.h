// Effect restitution: bodies that collide fast enough bounce.
//
// Acts before the sweeps of a sub-step, on contacts with a coefficient e > 0. Points that approach faster than
// kMinSpeed and would meet within two sub-steps separate at e times that speed (Newton), e the larger of the two
// bodies'; within two, because the relax sweep already brakes what would pass in the next sub-step. The speeds are
// corrected for gravity's work over the remaining gap: the bodies separate as they would at this gap after an impact at
// gap 0. The points of two bodies are solved together, up to kMaxStrikes of them: a block of two slices that falls flat
// does not bounce off one slice first. Pairs are solved one after the other, repeatedly and in alternating order, until
// no point approaches any more: so a row of balls transmits an impact from end to end. Steady loads (wrenches, the
// device) are applied later in the sub-step and cause no impact; otherwise resting bodies would bounce. An impact never
// adds kinetic energy: where the points of a contact have not converged, its impulses are scaled down. Impulses of
// impacts are not used as warm start. Units: SI. Thread: construction [setup]; the rest [rt], the owner of the World.
// Bound: kMaxRounds times the points of contacts with e > 0, each sub-step.
#pragma once

#include "rt/physics/effects/stage.h"

namespace tactus::physics {

class Restitution : public Stateless {
 public:
  static constexpr double kMinSpeed = 0.05;  // m/s: below this speed, resting contacts would jitter
  static constexpr std::uint32_t kMaxStrikes = 4 * kMaxManifoldPoints;
  static constexpr int kMaxRounds = 8;  // passes over the list, alternately from either end

  struct Setup {
    std::span<const double> by_id{};  // e by body id; bodies beyond the end have 0. Must outlive the world
    bool used() const noexcept { return !by_id.empty(); }
  };
  Restitution(const Setup& setup, const Capacities& capacities)
      : by_id_(setup.by_id), rows_(capacities.contacts), groups_(capacities.contacts) {}
  void register_stages(StageTable& table) noexcept;

 private:
  struct Row {
    std::uint32_t contact{0};
    double coefficient{};
    std::array<double, kMaxManifoldPoints> given{};  // N s, by point, over this step
  };
  // Rows of the same two bodies that are solved together.
  struct Group {
    std::uint32_t first{0}, count{0}, points{0};
  };
  struct Strike {
    std::uint32_t row{0}, point{0};
    double speed{};  // m/s, of approach
    double after{};  // m/s, of separation after the impact
    double mass{};
    double impulse{};  // N s
  };
  using Strikes = FixedVector<Strike, kMaxStrikes>;

  double coefficient_of(BodyId id) const noexcept { return id < by_id_.size() ? by_id_[id] : 0.0; }
  void list(StageContext& c) noexcept;
  void bounce(StageContext& c) noexcept;
  bool bounce_off(StageContext& c, const Group& group) noexcept;  // true if there was an impact
  void add_strikes(const StageContext& c, std::uint32_t row, Strikes& strikes) const noexcept;
  void add_to_group(const Contact& contact, const Contact* last) noexcept;
  void finish(StageContext& c) noexcept;

  std::span<const double> by_id_;
  BoundedVector<Row> rows_;  // by contact
  BoundedVector<Group> groups_;
};

}  // namespace tactus::physics
