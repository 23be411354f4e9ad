// Effect restitution: what hits fast enough bounces.
//
// After the sub-steps, over the points of contacts with a coefficient e > 0 that came together faster than kLeastSpeed
// and pressed: an impulse leaves them separating at e times the speed at which they came (Newton), e the larger of the
// two bodies'. The approach is that of the sub-step of the impact, before its sweeps, so that a fall within the step
// counts; what presses (wrenches, the device) does not: it would make resting bodies bounce. The
// points of one contact are gone over several times with sums of impulses that only push. Such an impulse is no force
// to start the next step with. Units: SI. Thread: construction [setup]; the rest [rt], the owner of the World. Bound:
// linear in the points of contacts with e > 0. Source: Catto, Box2D (restitution after the soft solver).
#pragma once

#include "rt/physics/effects/stage.h"

namespace tactus::physics {

template <class T>
class Restitution : public Stateless {
 public:
  static constexpr T kLeastSpeed = T(0.05);  // m/s: slower contacts would only make resting ones jitter

  struct Setup {
    std::span<const T> by_id{};  // e by body id; those beyond the end have 0. Must outlive the world
    bool used() const noexcept { return !by_id.empty(); }
  };
  Restitution(const Setup& setup, const Capacities& capacities)
      : by_id_(setup.by_id), rows_(capacities.contacts * kMaxManifoldPoints) {}
  void enter(StageTable<T>& table) noexcept;

 private:
  struct Row {
    std::uint32_t contact{0}, point{0};
    Vec3<T> r_a, r_b;  // m, at the start of the step
    T mass{}, coefficient{};
    T approach{};  // m/s, the most of a sub-step
    T impulse{};   // N s
  };

  T coefficient_of(BodyId id) const noexcept { return id < by_id_.size() ? by_id_[id] : T(0); }
  static T separating_speed(const StageContext<T>& c, const Row& row) noexcept;
  void list(StageContext<T>& c) noexcept;
  void note_approach(StageContext<T>& c) noexcept;
  void bounce(StageContext<T>& c) noexcept;

  std::span<const T> by_id_;
  BoundedVector<Row> rows_;
};

}  // namespace tactus::physics
