// Whole runs of two hands on the virtual clock: simulated devices, each with its loop and its sub-world, on one global
// world (tools/session/hands.h). Both pull at one bar; a part goes from hand to hand.
// They run at the device's tick, so there is no 10 ms step. The accuracy sets the sub-steps of both worlds.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "rt/base/check.h"
#include "rt/base/hash.h"
#include "tools/validation/case_scene.h"
#include "tools/validation/case_world.h"
#include "tools/validation/cases.h"
#include "tools/validation/two_hands.h"

namespace tactus::hard_cases {
namespace {

// A run, looked at after every tick.
class LookedAt {
 public:
  LookedAt(const std::string& text, const Setting& setting) : run_(made(case_scene(text, setting, 1000))) {}

  void run(std::uint64_t ticks, const TwoHands::Look& look) {
    std::array<double, 2> last{};
    const auto done = run_.run(ticks, [&](std::uint64_t tick) {
      for (unsigned hand = 0; hand < 2; ++hand) {
        const loop::TickOutput& out = run_[hand].driver->output();
        finite_ = finite_ && is_finite(out.command.wrench);
        faulted_ = faulted_ || out.fault != Fault::kNone;
        largest_ = std::max(largest_, norm(out.command.wrench.force));
        largest_step = std::max(largest_step, std::abs(force(hand) - last[hand]));
        last[hand] = force(hand);
      }
      look(tick);
    });
    TACTUS_CHECK(done.ok(), ticks, 0);
  }

  // Adds the gates of the run, and its hash.
  void gate(Outcome& outcome) {
    Fnv1a hash;
    std::uint64_t left_out = world().statistics().capacity_bits;
    hash.add(world().state_hash());
    for (unsigned hand = 0; hand < 2; ++hand) {
      hash.add(run_[hand].loop->state_hash());
      left_out |= run_[hand].stats.capacity_bits;
    }
    outcome.hash = hash.value();
    outcome.gate("finite", finite_);
    outcome.gate("no fault", !faulted_);
    outcome.gate("force within its limit", largest_ <= kMaxForce_N * (1 + 1e-9));
    outcome.gate("nothing left out", left_out == 0);
  }

  sim::GlobalWorld& world() { return run_.world(); }
  // N, of the command to the device, along x.
  double force(unsigned hand) const { return run_.force_N(hand).x; }
  bool holds_part(unsigned hand) { return run_.holds_part(hand); }
  double part_m() { return run_.part_x_m(); }

  double largest_step{0};  // N a tick, of both

 private:
  static TwoHands made(const sim::Scene& scene) {
    auto hands = TwoHands::create(scene);
    if (!hands.ok()) fmt::print(stderr, "{}\n", hands.message());
    TACTUS_CHECK(hands.ok(), 0, 0);
    return std::move(hands).value();
  }

  TwoHands run_;
  bool finite_{true}, faulted_{false};
  double largest_{0};
};

// Both hands pull by 20 mm on a bar that is jointed to both proxies; then the first pulls another 30 mm. Two pairs of
// springs carry the stretch, so half of the additional pull of one hand acts on the other.
Outcome tug_of_war(const Setting& setting) {
  LookedAt run(tug_text(), setting);
  std::array<double, 2> drawn{}, moved{};
  double ripple = 0;
  std::uint64_t held_by_one = 0;
  constexpr std::uint64_t kTicks = 2600;
  run.run(kTicks, [&](std::uint64_t tick) {
    for (unsigned hand = 0; hand < 2; ++hand) {
      if (tick == 999) drawn[hand] = run.force(hand);
      if (tick == kTicks - 1) moved[hand] = run.force(hand);
    }
    if (tick >= 2300) ripple = std::max(ripple, std::abs(run.force(0) + run.force(1)));
    if (run.holds_part(0) != run.holds_part(1)) ++held_by_one;
  });
  const double first = in_series_N(0.02), then = in_series_N(0.5 * (0.02 + 0.05));
  Outcome outcome;
  run.gate(outcome);
  outcome.near("force of the first, both drawn, N", drawn[0], first, kDryFriction_N);
  outcome.near("force of the second, N", drawn[1], -first, kDryFriction_N);
  outcome.near("force of the first, drawn further, N", moved[0], then, kDryFriction_N);
  outcome.near("force of the second, N", moved[1], -then, kDryFriction_N);
  outcome.at_most("ripple of their sum, N", ripple, 0.02 * then);
  outcome.at_most("largest step of a force, N", run.largest_step, 0.05 * then);
  outcome.near("ticks in which one sub-world has the bar", static_cast<double>(held_by_one), kTicks, 0);
  return outcome;
}

// A block on the ground, that the first hand pushes towards the second, which pushes it back when the first has gone.
Outcome hand_over(const Setting& setting) {
  LookedAt run(hand_over_text(), setting);
  std::vector<unsigned> holders;
  double pushed = 0, both = 0;
  std::array<double, 2> most{};
  run.run(3000, [&](std::uint64_t tick) {
    for (unsigned hand = 0; hand < 2; ++hand) {
      if (run.holds_part(hand) && (holders.empty() || holders.back() != hand)) holders.push_back(hand);
      most[hand] = std::max(most[hand], std::abs(run.force(hand)));
    }
    if (run.holds_part(0) && run.holds_part(1)) ++both;
    if (tick == 1900) pushed = run.part_m();
  });
  // The block stops where the springs carry no more than its friction on the ground: at most `sag` short of where the
  // hand ends, and not beyond. Where in that range its momentum decides. The device's own friction shifts it by F / k.
  const double friction = 0.5 * kGravity * 0.5;
  const double sag = friction / kHand_N_per_m + friction / kCoupling_N_per_m, off = kDryFriction_N / kHand_N_per_m;
  Outcome outcome;
  run.gate(outcome);
  outcome.holds("the first has it, then the second", holders == std::vector<unsigned>{0, 1});
  outcome.near("handed over, times", static_cast<double>(run.world().statistics().handed_over), 1, 0);
  outcome.at_most("ticks in which both have it", both, 0);
  outcome.near("pushed to, m", pushed, -0.02 + 0.06 - 0.5 * sag, 0.5 * sag + off);
  outcome.near("pushed back to, m", run.part_m(), 0.04 - 0.06 + 0.5 * sag, 0.5 * sag + off);
  for (unsigned hand = 0; hand < 2; ++hand) {
    outcome.holds(fmt::format("hand {} feels the friction", hand + 1), most[hand] > 0.9 * friction);
    outcome.at_most(fmt::format("most force on hand {}, N", hand + 1), most[hand], 2 * friction);
  }
  outcome.at_most("largest step of a force, N", run.largest_step, 0.5 * friction);
  return outcome;
}

}  // namespace

std::vector<HardCase> hands_cases() {
  return {{.number = 110, .name = "tug of war", .global_step = false, .run = tug_of_war},
          {.number = 111, .name = "part from hand to hand", .global_step = false, .run = hand_over}};
}

}  // namespace tactus::hard_cases
