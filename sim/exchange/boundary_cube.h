// Finds the bodies that the proxy could reach before they can become members; they must be members already.
//
// The members of cycle n + 1 are chosen while cycle n runs, from the proxy's state at t_n, and stay until t_(n+2): two
// cycles. In that time the proxy translates by up to 2 r T v_max, rotation moves its surface by up to 2 r T w_max R,
// and the other body approaches. The paper's text says two cycles as well; its formula has one, without rotation or the
// other body's motion: Reach::kPaper.
// Thread: the global world's; never allocates. Frame: world. Units: SI. Work: linear in bodies, a few ns for each that
// is far away. Bound: all bodies fit. Source: the paper, section 2.1.
#pragma once

#include <span>
#include <vector>

#include "rt/physics/body.h"
#include "sim/body_index.h"

namespace tactus::sim {

enum class Reach : std::uint32_t {
  kTwoCycles = 0,
  kPaper = 1,
};

struct ReachSettings {
  Reach reach{Reach::kTwoCycles};
  unsigned ratio{10};
  double tick_period_s{1e-3};
  double max_speed_m_per_s{1};  // of the proxy: the device's maximum, scaled to the scene
  double max_angular_speed_rad_per_s{10};
  double margin_m{1e-3};  // kTwoCycles only
};

// p_max: bound on the motion of the proxy's surface until the choice takes effect.
double reach_of_proxy_m(const ReachSettings& settings, double proxy_radius_m) noexcept;
// Bound on the motion of another body's surface in that time; 0 for kPaper.
double reach_of_body_m(const ReachSettings& settings, const Twistd& velocity, double body_radius_m) noexcept;

struct CloseBody {
  BodyIndex index{};
  double gap_m{0};  // between the boxes of proxy and body, minus the body's reach; negative: they may overlap
};

class BoundaryCube {
 public:
  // [setup] `bodies`: all, for the whole run.
  BoundaryCube(const ReachSettings& settings, BodySpan<const physics::Body> bodies, BodyIndex proxy);

  // The cube of side c_size + 2 p_max centred on the proxy at `world_from_proxy`.
  physics::Aabb region(const physics::Body& proxy, const Posed& world_from_proxy) const noexcept;

  // All bodies but the proxy whose grown boxes intersect region(), nearest first, ties by index. Valid until the next
  // call. `among`: bodies to test; empty: all.
  std::span<const CloseBody> find(BodySpan<const physics::Body> bodies, const Posed& world_from_proxy,
                                  std::span<const BodyIndex> among = {}) noexcept;

 private:
  double half_side_m(const physics::Body& proxy, const Posed& world_from_proxy) const noexcept;

  ReachSettings settings_;
  BodyIndex proxy_;
  double proxy_reach_m_;
  BodyVector<double> radius_m_;
  std::vector<CloseBody> close_;
};

}  // namespace tactus::sim
