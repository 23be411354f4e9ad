#include "tools/validation/two_hands.h"

#include <fmt/format.h>

#include "tools/session/virtual_run.h"

namespace tactus::hard_cases {
namespace {

// Two proxies on both sides of x = 0, and where each hand's target goes along x, by way points of half a second.
std::string hands_text(double start_m, double height_m, const std::array<std::vector<double>, 2>& paths_m) {
  std::string text;
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

}  // namespace

std::string two_hands_head() {
  return fmt::format(
      "[simulation]\nratio = 10\nmembers = 8\n[coupling]\nstiffness_N_per_m = {}\ndamping_Ns_per_m = 5\n"
      "stiffness_Nm_per_rad = 4\ndamping_Nms_per_rad = 0.02\n",
      kCoupling_N_per_m);
}

std::string tug_text() {
  return "effects = [\"friction\", \"gyroscopic\", \"joints\"]\n" + two_hands_head() +
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
)";
}

std::string hand_over_text() {
  return "effects = [\"gravity\", \"friction\", \"gyroscopic\"]\n" + two_hands_head() +
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
)";
}

Result<TwoHands> TwoHands::create(const sim::Scene& scene, const std::array<std::string, 2>& injects,
                                  haptics::CouplingScheme coupling) {
  session::RunOptions options;
  options.virtual_time = true;
  options.duration_s = 1;
  options.coupling = coupling;
  std::vector<session::RunOptions> of_hands(2, options);
  for (std::size_t hand = 0; hand < 2; ++hand) of_hands[hand].inject = injects[hand];
  auto hands = session::Hands::create(scene, std::move(of_hands), std::vector<session::Hardware>(2));
  if (!hands.ok()) return hands.status();
  return TwoHands(std::move(hands).value());
}

Result<std::vector<session::RunSummary>> TwoHands::run(std::uint64_t ticks, const Look& look) {
  std::uint64_t tick = 0;
  return session::run_virtual(hands_, ticks, [&](const session::Hands&) {
    if (look) look(tick);
    ++tick;
    return true;
  });
}

}  // namespace tactus::hard_cases
