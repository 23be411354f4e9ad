// Effect attraction: points that pull at bodies from afar, as a magnet pulls at iron.
//
// F = strength x weight x d / (d^2 + softening^2)^(3/2), d from the body's centre to the source: falls with the square
// of the distance, is largest at 0.7 softening and zero at the source. Explicit, so softening bounds how stiff it is. A
// source that is a body feels the opposite force; one that is another world's body at the time pulls at nobody here.
// Frame: world. Units: SI. Thread: [rt], the owner of the World. Bound: sources x bodies.
#pragma once

#include "rt/physics/effects/stage.h"

namespace tactus::physics {

inline constexpr std::uint32_t kMaxAttractionSources = 32;

struct AttractionSource {
  BodyId body{kNoBody};   // fixed or moving; kNoBody: a place
  Vec3d position_m;       // the place
  double strength_Nm2{};  // negative: pushes away
  double softening_m{0.01};
};

class Attraction : public Stateless {
 public:
  struct Setup {
    FixedVector<AttractionSource, kMaxAttractionSources> sources{};
    std::span<const double> weight_by_id{};  // those beyond the end have 0. Must outlive the world
    bool used() const noexcept { return !sources.empty() && !weight_by_id.empty(); }
  };
  Attraction(const Setup& setup, const Capacities&) noexcept : setup_(setup) {}
  void enter(StageTable& table) noexcept { table.add<&Attraction::pull>(Phase::kForces, *this); }

 private:
  void pull(StageContext& c) noexcept;

  Setup setup_;
};

}  // namespace tactus::physics
