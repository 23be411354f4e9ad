// Scenes of two hands for tests and hard cases, a run of them on the virtual clock, and the formula of what the hands
// feel. Two balls on springs along x: both pull at one bar, or a block goes from one to the other.
// Thread: normal. Frame: world. Units: in the names.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "tools/session/hands.h"

namespace tactus::hard_cases {

constexpr double kHand_N_per_m = 400, kCoupling_N_per_m = 600;  // the default hand's, and of these scenes
constexpr double kDryFriction_N = 0.2;                          // of the simulated device
constexpr sim::BodyIndex kPart{2};                              // the body after the two proxies

// The hand's spring and the coupling's in series.
constexpr double in_series_N(double stretch_m) { return stretch_m / (1 / kHand_N_per_m + 1 / kCoupling_N_per_m); }

// [simulation] and [coupling] of these scenes.
std::string two_hands_head();
// A bar between two balls, jointed to both: both draw 20 mm, then the first another 30 mm.
std::string tug_text();
// A block on the ground, that the first hand pushes towards the second, which pushes it back when the first has gone.
std::string hand_over_text();

// A run of such a scene.
class TwoHands {
 public:
  // `injects`: of each hand. Error: of session::Hands::create.
  static Result<TwoHands> create(const sim::Scene& scene, const std::array<std::string, 2>& injects = {},
                                 haptics::CouplingScheme coupling = haptics::CouplingScheme::kSubWorld);

  // `look` is called after each tick; may be empty. Returns a summary for each hand.
  using Look = std::function<void(std::uint64_t tick)>;
  Result<std::vector<session::RunSummary>> run(std::uint64_t ticks, const Look& look);

  session::Hands& hands() noexcept { return hands_; }
  session::Session& operator[](unsigned hand) noexcept { return hands_[hand]; }
  sim::GlobalWorld& world() noexcept { return hands_.world(); }
  // Of the command to the device.
  Vec3d force_N(unsigned hand) const noexcept { return hands_[hand].driver->output().command.wrench.force; }
  bool holds_part(unsigned hand) { return world().extraction(hand).is_member(kPart); }
  double part_x_m() { return world().bodies()[number_of(kPart)].motion.pose.position.x; }

 private:
  explicit TwoHands(session::Hands hands) : hands_(std::move(hands)) {}

  session::Hands hands_;
};

}  // namespace tactus::hard_cases
