// The scene that goes with a new description (new_description.h).
#include <fmt/format.h>

#include <algorithm>

#include "rt/haptics/coupling_limits.h"
#include "tools/device/new_description.h"

namespace tactus::device {
namespace {

// Share of the suggested gains. The text of the scene has fewer digits than the description; rounded gains must pass.
constexpr double kOfSuggested = 0.95;
constexpr unsigned kContact_Hz = 250;     // or a quarter of the rate, which the usual sub-steps resolve
constexpr double kPressed_N = 3;          // by the hand into the floor, or less where the device cannot for long
constexpr double kPressedOfRadius = 0.2;  // and no deeper than this share of the workspace's radius

haptics::CouplingGains gains_of(const hal::DeviceProfile& profile, unsigned rate_Hz) {
  haptics::DeviceProperties properties = profile.properties;
  const double period_s = 1.0 / rate_Hz;
  properties.delay_s = profile.transport_delay_ticks * period_s;
  return haptics::suggest_gains(properties, period_s);
}

}  // namespace

std::string scene_text(const hal::DeviceProfile& profile, unsigned rate_Hz) {
  const haptics::CouplingGains gains = gains_of(profile, rate_Hz);
  const double radius_m = profile.description.workspace_radius_m, proxy_m = std::min(0.01, 0.1 * radius_m);
  const double stiffness = kOfSuggested * gains.stiffness_N_per_m;
  const double press_N = std::min(kPressed_N, 0.7 * profile.description.continuous_force_N);
  // Where the hand begins, at the workspace's centre, the proxy is a quarter of the radius above the floor.
  const double centre_m = proxy_m + 0.25 * radius_m;
  const double pressed_m = proxy_m - std::min(press_N / stiffness, kPressedOfRadius * radius_m);
  const double box_m = 0.2 * radius_m, aside_m = 0.3 * radius_m;
  std::string text = fmt::format(
      "# Written by `tactus device new`: a floor and a box, with gains that {} bears at {} Hz.\n"
      "title = \"Try {}\"\neffects = [\"gravity\", \"friction\"]\n\n[simulation]\nratio = 2\nmembers = 8\n"
      "contact_hertz_Hz = {}\n\n",
      profile.name, rate_Hz, profile.name, std::min(kContact_Hz, rate_Hz / 4));
  text += fmt::format(
      "[device]\nprofile = \"{}\"  # --device-file has the place of it\nposition_m = [0, 0, {:.4g}]\n\n"
      "[coupling]\nstiffness_N_per_m = {:.4g}\ndamping_Ns_per_m = {:.4g}\n",
      profile.description.has_rotation() ? "virtuose6d" : "desk3d", centre_m, stiffness, gains.damping_Ns_per_m);
  if (profile.description.has_rotation())
    text += fmt::format("stiffness_Nm_per_rad = {:.4g}\ndamping_Nms_per_rad = {:.4g}\n",
                        kOfSuggested * gains.stiffness_Nm_per_rad, gains.damping_Nms_per_rad);
  text += fmt::format(
      "\n[proxy]\nshape = \"sphere\"\nradius_m = {0:.4g}\nmass_kg = 0.1\nfriction = 0.3\nposition_m = [0, 0, "
      "{1:.4g}]\n\n"
      "[[body]]\nshape = \"plane\"\nfriction = 0.5\n\n"
      "[[body]]\nshape = \"box\"\nsize_m = [{2:.4g}, {2:.4g}, {2:.4g}]\nmass_kg = 0.05\nfriction = 0.4\n"
      "position_m = [{3:.4g}, 0, {4:.4g}]\n\n",
      proxy_m, centre_m, box_m, aside_m, 0.5 * box_m);
  return text +
         fmt::format(
             "[hand]\nrepeat = true\npath = [\n  {{time_s = 0, position_m = [0, 0, {0:.4g}]}},\n"
             "  {{time_s = 2, position_m = [0, 0, {1:.4g}]}},\n  {{time_s = 5, position_m = [{2:.4g}, 0, {1:.4g}]}},\n"
             "  {{time_s = 7, position_m = [0, {2:.4g}, {0:.4g}]}},\n  {{time_s = 9, position_m = [0, 0, "
             "{0:.4g}]}},\n]\n",
             centre_m, pressed_m, aside_m);
}

}  // namespace tactus::device
