// Whole runs of two hands on the virtual clock: simulated devices, each with its loop and its sub-world, on one global
// world (tools/session/hands.h). Both pull at one bar; a part goes from hand to hand.
// They run at the device's tick, so there is no 10 ms step. The accuracy sets the sub-steps of both worlds.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>

#include "rt/base/check.h"
#include "rt/base/hash.h"
#include "tools/session/hands.h"
#include "tools/session/virtual_run.h"
#include "tools/validation/case_scene.h"
#include "tools/validation/case_world.h"
#include "tools/validation/cases.h"

namespace tactus::hard_cases {
namespace {

constexpr double kHand = 400, kCoupling = 600;  // N/m: the default hand's, and of the scenes below
constexpr double kDryFriction_N = 0.2;          // of the simulated device
constexpr double kMaxForce_N = 30;
constexpr sim::BodyIndex kPart{2};  // the body after the two proxies

constexpr const char* kHead = R"(
[simulation]
ratio = 10
members = 8
[coupling]
stiffness_N_per_m = 600
damping_Ns_per_m = 5
stiffness_Nm_per_rad = 4
damping_Nms_per_rad = 0.02
)";

// Two proxies on both sides of x = 0, and where each hand's target goes along x, by way points of half a second.
std::string hands_text(double start_m, double height_m, const std::array<std::vector<double>, 2>& paths_m) {
  std::string text = kHead;
  for (std::size_t hand = 0; hand < 2; ++hand) {
    text += fmt::format(
        "[[proxy]]\nshape = \"sphere\"\nradius_m = 0.01\nmass_kg = 0.2\nfriction = 0.3\n"
        "position_m = [{0}, 0, {1}]\n[[device]]\nposition_m = [{0}, 0, {1}]\n[[hand]]\nrepeat = false\npath = [\n",
        hand == 0 ? -start_m : start_m, height_m);
    double time_s = 0;
    for (const double x_m : paths_m[hand]) {
      text += fmt::format("{{time_s = {}, position_m = [{}, 0, {}]}},\n", time_s, x_m, height_m);
      time_s += 0.5;
    }
    text += "]\n";
  }
  return text;
}

// A run, looked at after every tick.
class TwoHands {
 public:
  TwoHands(const std::string& text, const Setting& setting) : hands_(made(case_scene(text, setting, 1000))) {}

  void run(std::uint64_t ticks, const std::function<void(std::uint64_t tick)>& look) {
    std::uint64_t tick = 0;
    std::array<double, 2> last{};
    const auto done = session::run_virtual(hands_, ticks, [&](const session::Hands&) {
      for (unsigned hand = 0; hand < 2; ++hand) {
        const loop::TickOutput& out = hands_[hand].driver->output();
        finite_ = finite_ && is_finite(out.command.wrench);
        faulted_ = faulted_ || out.fault != Fault::kNone;
        largest_ = std::max(largest_, norm(out.command.wrench.force));
        largest_step = std::max(largest_step, std::abs(force(hand) - last[hand]));
        last[hand] = force(hand);
      }
      look(tick++);
      return true;
    });
    TACTUS_CHECK(done.ok(), ticks, 0);
  }

  // Adds the gates of the run, and its hash.
  void gate(Outcome& outcome) {
    Fnv1a hash;
    std::uint64_t left_out = world().statistics().capacity_bits;
    hash.add(world().state_hash());
    for (unsigned hand = 0; hand < 2; ++hand) {
      hash.add(hands_[hand].loop->state_hash());
      left_out |= hands_[hand].stats.capacity_bits;
    }
    outcome.hash = hash.value();
    outcome.gate("finite", finite_);
    outcome.gate("no fault", !faulted_);
    outcome.gate("force within its limit", largest_ <= kMaxForce_N * (1 + 1e-9));
    outcome.gate("nothing left out", left_out == 0);
  }

  sim::GlobalWorld& world() { return hands_.world(); }
  // N, of the command to the device, along x.
  double force(unsigned hand) const { return hands_[hand].driver->output().command.wrench.force.x; }
  bool holds_part(unsigned hand) { return world().extraction(hand).is_member(kPart); }
  double part_m() { return world().bodies()[number_of(kPart)].motion.pose.position.x; }

  double largest_step{0};  // N a tick, of both

 private:
  static session::Hands made(const sim::Scene& scene) {
    session::RunOptions options;
    options.virtual_time = true;
    options.duration_s = 1;
    auto hands = session::Hands::create(scene, {options, options}, std::vector<session::Hardware>(2));
    if (!hands.ok()) fmt::print(stderr, "{}\n", hands.message());
    TACTUS_CHECK(hands.ok(), 0, 0);
    return std::move(hands).value();
  }

  session::Hands hands_;
  bool finite_{true}, faulted_{false};
  double largest_{0};
};

// The hand's spring and the coupling's one behind the other.
double in_series(double stretch_m) { return stretch_m / (1 / kHand + 1 / kCoupling); }

// Both hands draw 20 mm at a bar that is jointed to both proxies, then the first another 30 mm: two pairs of springs
// carry the stretch, and half of what one hand draws more is felt by the other.
Outcome tug_of_war(const Setting& setting) {
  TwoHands run("effects = [\"friction\", \"gyroscopic\", \"joints\"]\n" +
                   hands_text(0.04, 0, {{{-0.04, -0.06, -0.06, -0.09}, {0.04, 0.06}}}) + R"(
[[body]]
name = "bar"
shape = "box"
size_m = [0.05, 0.02, 0.02]
mass_kg = 0.3
[[joint]]
kind = "ball"
a = "bar"
b = "proxy"
position_m = [-0.04, 0, 0]
[[joint]]
kind = "ball"
a = "bar"
b = "proxy2"
position_m = [0.04, 0, 0]
)",
               setting);
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
  const double first = in_series(0.02), then = in_series(0.5 * (0.02 + 0.05));
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
  TwoHands run("effects = [\"gravity\", \"friction\", \"gyroscopic\"]\n" +
                   hands_text(0.09, 0.03,
                              {{{-0.09, -0.05, -0.02, -0.02, -0.06, -0.09, -0.09, -0.09},
                                {0.09, 0.1, 0.1, 0.09, 0.09, 0.06, 0.04, 0.09}}}) +
                   R"(
[[body]]
shape = "box"
size_m = [0.1, 0.1, 0.06]
mass_kg = 0.5
friction = 0.5
position_m = [0, 0, 0.03]
[[body]]
shape = "plane"
friction = 0.5
)",
               setting);
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
  const double sag = friction / kHand + friction / kCoupling, off = kDryFriction_N / kHand;
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
  return {{110, "tug of war", false, tug_of_war}, {111, "part from hand to hand", false, hand_over}};
}

}  // namespace tactus::hard_cases
