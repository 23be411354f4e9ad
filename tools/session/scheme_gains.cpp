#include "tools/session/scheme_gains.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "rt/haptics/interpolation_limit.h"
#include "sim/model/choice_names.h"
#include "sim/model/rounded_down.h"
#include "tools/session/session.h"

namespace tactus::session {
namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();

double square(double x) { return x * x; }

// Allowed stiffness for a stability limit.
double allowed(double limit) { return limit == kNone ? kNone : haptics::kAllowedStiffnessShare * limit; }

double lowered(double asked, double limit) {
  return asked <= allowed(limit) ? asked : sim::rounded_down(allowed(limit));
}

Status refuse_device_gains(const sim::Scene& scene, const RunOptions& options, const haptics::DeviceProperties& device,
                           const haptics::CouplingVerdict& verdict) {
  const double s2 = square(scene.device.motion_scale);
  const haptics::CouplingGains use = haptics::suggest_gains(device, options.period_s(), options.late_s);
  const std::string late =
      options.late_s > 0 ? fmt::format(" that wakes up to {:.0f} us late", 1e6 * options.late_s) : "";
  // In the units of the scene's keys; values at the hand are `scale` times these (motion_scale).
  const auto line = [&](const haptics::AxisVerdict& v, double scale, const char* stiffness, const char* damping,
                        double use_stiffness, double use_damping) {
    const double most = sim::rounded_down(v.stiffness_allowed / scale);
    const std::string accepted =
        most > 0 ? fmt::format("{} up to {:g} with that damping ({:g} of the limit {:.4g})", stiffness, most,
                               haptics::kAllowedStiffnessShare, v.stiffness_limit / scale)
                 : fmt::format("{} up to {:g}, such as {:g} with {} = {:g}", damping,
                               sim::rounded_down(v.damping_limit / scale), sim::rounded_down(use_damping / scale),
                               stiffness, sim::rounded_down(use_stiffness / scale));
    const std::string frame =
        scale == 1 ? "" : fmt::format(", all as in the scene: at the hand {:g} times as much", scale);
    return Status::error(fmt::format(
        "{}: [coupling] {} = {:g} with {} = {:g} is not stable at {:g} Hz on this device{}; accepted: {}{}", scene.name,
        stiffness, v.stiffness / scale, damping, v.damping / scale, options.rate_Hz, late, accepted, frame));
  };
  return verdict.translation.accepted ? line(verdict.rotation, 1, "stiffness_Nm_per_rad", "damping_Nms_per_rad",
                                             use.stiffness_Nm_per_rad, use.damping_Nms_per_rad)
                                      : line(verdict.translation, s2, "stiffness_N_per_m", "damping_Ns_per_m",
                                             use.stiffness_N_per_m, use.damping_Ns_per_m);
}

// Translation or rotation, in the units of the scene's keys.
struct ScenesAxis {
  const char *name, *key, *stiffness_unit, *damping_unit;
  double stiffness, damping;  // asked for
  double used, limit;         // stiffness used, and its limit by the scheme
};

std::array<ScenesAxis, 2> axes_of(const SchemeGains& g) {
  return {{{.name = "translational",
            .key = "stiffness_N_per_m",
            .stiffness_unit = "N/m",
            .damping_unit = "N s/m",
            .stiffness = g.asked.stiffness_N_per_m,
            .damping = g.asked.damping_Ns_per_m,
            .used = g.gains.stiffness_N_per_m,
            .limit = g.stiffness_limit_N_per_m},
           {.name = "rotational",
            .key = "stiffness_Nm_per_rad",
            .stiffness_unit = "N m/rad",
            .damping_unit = "N m s/rad",
            .stiffness = g.asked.stiffness_Nm_per_rad,
            .damping = g.asked.damping_Nms_per_rad,
            .used = g.gains.stiffness_Nm_per_rad,
            .limit = g.stiffness_limit_Nm_per_rad}}};
}

// Error about the limit of the coupling scheme.
Status refuse_scheme_gains(const sim::Scene& scene, const RunOptions& options, const ScenesAxis& axis) {
  const std::string instead =
      axis.limit > 0 ? fmt::format("use {} = {:g}, a lower --ratio, or the scene without --keep-gains", axis.key,
                                   sim::rounded_down(allowed(axis.limit)))
                     : std::string("no stiffness is stable with that damping: use a lower --ratio or less damping");
  const double step_ms = 1e3 * ratio_of(scene, options) * options.period_s();
  const std::string why =
      options.hands > 1
          ? fmt::format("where {} hands hold one body at ratio {}: each feels the other {:g} to {:g} ms late",
                        options.hands, ratio_of(scene, options), step_ms, 2 * step_ms)
          : fmt::format("with --coupling {} at ratio {}, which delays the proxy by {:g} ms",
                        sim::name_of(options.coupling), ratio_of(scene, options), step_ms);
  return Status::error(
      fmt::format("{}: [coupling] {} stiffness {:g} {} with damping {:g} {} is not stable {}; accepted: up to {:.4g} "
                  "{} ({:g} of the limit {:.4g}); {}",
                  scene.name, axis.name, axis.stiffness, axis.stiffness_unit, axis.damping, axis.damping_unit, why,
                  allowed(axis.limit), axis.stiffness_unit, haptics::kAllowedStiffnessShare, axis.limit, instead));
}

}  // namespace

SchemeGains gains_of(const sim::Scene& scene, const RunOptions& options, const haptics::DeviceProperties& device) {
  SchemeGains result;
  result.gains = result.asked = scene.coupling;
  result.stiffness_limit_N_per_m = result.stiffness_limit_Nm_per_rad = kNone;
  if (options.hands > 1 && options.shared_limits) {
    result.stiffness_limit_N_per_m = options.shared_limits->stiffness_N_per_m;
    result.stiffness_limit_Nm_per_rad = options.shared_limits->stiffness_Nm_per_rad;
    result.gains.stiffness_N_per_m = lowered(result.asked.stiffness_N_per_m, result.stiffness_limit_N_per_m);
    result.gains.stiffness_Nm_per_rad = lowered(result.asked.stiffness_Nm_per_rad, result.stiffness_limit_Nm_per_rad);
    return result;
  }
  if (traits_of(options.coupling).model != haptics::LocalModel::kInterpolatedProxy) return result;
  const double s2 = square(scene.device.motion_scale);
  const physics::Body& proxy = scene.bodies[scene.proxy];
  const unsigned ratio = ratio_of(scene, options);
  haptics::InterpolatedProxy moved{s2 * proxy.mass, ratio, scene.solver.global_sub_steps(ratio)};
  const auto linear = haptics::translation_of(device, options.period_s(), options.late_s);
  result.stiffness_limit_N_per_m =
      haptics::interpolation_stiffness_limit(linear, moved, s2 * result.asked.damping_Ns_per_m) / s2;
  result.gains.stiffness_N_per_m = lowered(result.asked.stiffness_N_per_m, result.stiffness_limit_N_per_m);
  if (!device.has_rotation) return result;
  moved.mass = std::min({proxy.inertia.x, proxy.inertia.y, proxy.inertia.z});
  const auto angular = haptics::rotation_of(device, options.period_s(), options.late_s);
  result.stiffness_limit_Nm_per_rad =
      haptics::interpolation_stiffness_limit(angular, moved, result.asked.damping_Nms_per_rad);
  result.gains.stiffness_Nm_per_rad = lowered(result.asked.stiffness_Nm_per_rad, result.stiffness_limit_Nm_per_rad);
  return result;
}

Status check_gains(const sim::Scene& scene, const RunOptions& options, const haptics::DeviceProperties& device) {
  const auto verdict = haptics::check_coupling(scene.coupling.at_hand(scene.device.motion_scale), device,
                                               options.period_s(), options.late_s);
  if (!verdict.accepted) return refuse_device_gains(scene, options, device, verdict);
  for (const ScenesAxis& axis : axes_of(gains_of(scene, options, device)))
    if (axis.used < axis.stiffness && (options.keep_gains || axis.limit <= 0))
      return refuse_scheme_gains(scene, options, axis);
  return Status::good();
}

std::string lowered_why(const RunOptions& options, unsigned ratio) {
  if (options.hands > 1)
    return fmt::format("the most that {} hands on one light body bear at ratio {}", options.hands, ratio);
  return fmt::format("the most that --coupling {} bears at ratio {}", sim::name_of(options.coupling), ratio);
}

std::string lowered_text(const SchemeGains& found) {
  std::string text;
  for (const ScenesAxis& axis : axes_of(found))
    if (axis.used < axis.stiffness)
      text += fmt::format("{}stiffness {:g} -> {:g} {} (limit {:.4g})", text.empty() ? "" : ", ", axis.stiffness,
                          axis.used, axis.stiffness_unit, axis.limit);
  return text;
}

}  // namespace tactus::session
