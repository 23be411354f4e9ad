// Effect attraction: point sources that attract bodies at a distance, as a magnet attracts iron.
//
// F = strength x weight x d / (d^2 + softening^2)^(3/2), d from the body's centre to the source: falls with the square
// of the distance, is largest at 0.7 softening and zero at the source. Explicit integration, so `softening` must bound
// the stiffness. A source that is a body receives the opposite force; a source whose body is presently in another world
// exerts no force here.
// Frame: world. Units: SI. Thread: [rt], the owner of the World. Bound: sources x bodies.
#pragma once

#include "rt/physics/effects/stage.h"

namespace tactus::physics {

inline constexpr std::uint32_t kMaxAttractionSources = 32;

struct AttractionSource {
  BodyId body{kNoBody};   // the source: fixed or moving; kNoBody: a fixed position
  Vec3d position_m;       // the position, if there is no body
  double strength_Nm2{};  // negative: repels
  double softening_m{0.01};
};

class Attraction : public Stateless {
 public:
  struct Setup {
    FixedVector<AttractionSource, kMaxAttractionSources> sources{};
    std::span<const double> weight_by_id{};  // bodies beyond the end have 0. Must outlive the world
    bool used() const noexcept { return !sources.empty() && !weight_by_id.empty(); }
  };
  Attraction(const Setup& setup, const Capacities&) noexcept : setup_(setup) {}
  void register_stages(StageTable& table) noexcept { table.add<&Attraction::pull>(Phase::kForces, *this); }

 private:
  void pull(StageContext& c) noexcept;

  Setup setup_;
};

}  // namespace tactus::physics
