// Which bodies the proxy could reach before they can become members: they must be members already.
//
// Cycle n + 1 is chosen while cycle n runs, from the proxy's state at t_n, and has to do until t_(n+2): two cycles. In
// them the proxy moves 2 r T v_max, its own far end turns 2 r T w_max R further, and the other body comes to meet it.
// The paper's text says two cycles as well, its formula one, without rotation or the other body: Reach::kPaper.
// Thread: the global world's; never allocates. Frame: world. Units: SI. Work: linear in bodies, a few ns each for
// those far away. Bound: all bodies fit. Source: the paper, section 2.1.
#pragma once

#include <span>
#include <vector>

#include "rt/physics/body.h"

namespace tactus::sim {

enum class Reach : std::uint32_t {
  kTwoCycles = 0,
  kPaper = 1,
};

struct ReachSettings {
  Reach reach{Reach::kTwoCycles};
  unsigned ratio{10};
  double tick_period_s{1e-3};
  double max_speed_m_per_s{1};  // of the proxy: the device's, in the scene's scale
  double max_angular_speed_rad_per_s{10};
  double margin_m{1e-3};  // kTwoCycles only
};

// How far the proxy's surface can move before the choice takes effect: p_max.
double reach_of_proxy_m(const ReachSettings& settings, double proxy_radius_m) noexcept;
// How far another body's surface can come to meet it; 0 for kPaper.
double reach_of_body_m(const ReachSettings& settings, const Twistd& velocity, double body_radius_m) noexcept;

struct CloseBody {
  std::uint32_t slot{0};
  double gap_m{0};  // between the boxes of proxy and body, less what the body can move; negative: they may overlap
};

class BoundaryCube {
 public:
  // [setup] `bodies` by slot, for the whole run.
  BoundaryCube(const ReachSettings& settings, std::span<const physics::Body> bodies, std::uint32_t proxy);

  // The cube of side c_size + 2 p_max around the proxy at `world_from_proxy`.
  physics::Aabb region(const physics::Body& proxy, const Posed& world_from_proxy) const noexcept;

  // All bodies but the proxy that intersect the cube of side c_size + 2 p_max around the proxy at `world_from_proxy`,
  // nearest first, ties by slot. Valid until the next call. `among`: slots to look at; empty: all.
  std::span<const CloseBody> find(std::span<const physics::Body> bodies, const Posed& world_from_proxy,
                                  std::span<const std::uint32_t> among = {}) noexcept;

 private:
  double half_side_m(const physics::Body& proxy, const Posed& world_from_proxy) const noexcept;

  ReachSettings settings_;
  std::uint32_t proxy_;
  double proxy_reach_m_;
  std::vector<double> radius_m_;  // by slot
  std::vector<CloseBody> close_;
};

}  // namespace tactus::sim
