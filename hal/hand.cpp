#include "hal/hand.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace tactus::hal {
namespace {

struct SmoothStep {
  double share, rate;  // fraction of the distance, 0 to 1; its derivative by u
};

// 10 u^3 - 15 u^4 + 6 u^5: first and second derivatives vanish at both ends.
SmoothStep smooth_step(double u) noexcept {
  const double rest = 1.0 - u;
  return {u * u * u * (10.0 + u * (-15.0 + 6.0 * u)), 30.0 * u * u * rest * rest};
}

// Return to the start: base duration for acceleration and deceleration, and speeds.
constexpr double kReturnStart_s = 0.3, kReturnSpeed_m_per_s = 0.2, kReturnSpeed_rad_per_s = 2.0;

bool is_finite_and_at_least(double x, double least) noexcept { return std::isfinite(x) && x >= least; }

}  // namespace

HandModel::HandModel(const HandParameters& parameters, std::span<const HandWaypoint> path) : parameters_(parameters) {
  if (path.empty()) return;
  const auto pose_of = [](const HandWaypoint& w) {
    return Posed{w.position_m, quat_from_rotation_vector(w.rotation_vector_rad)};
  };
  first_.pose = pose_of(path.front());
  last_.pose = pose_of(path.back());
  start_s_ = path.front().time_s;
  end_s_ = path.back().time_s;
  segments_.reserve(path.size());
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    const HandWaypoint &from = path[i], &to = path[i + 1];
    Segment segment = Segment::between(pose_of(from), pose_of(to), from.time_s, to.time_s - from.time_s);
    segment.motion = parameters.motion;
    segment.start_velocity = from.velocity_m_per_s;
    segment.end_velocity = to.velocity_m_per_s;
    segment.start_turn_rate = from.angular_velocity_rad_per_s;
    segment.end_turn_rate = rate_of_rotation_vector(segment.turn, to.angular_velocity_rad_per_s);
    segments_.push_back(segment);
  }
}

Status HandModel::check(const HandParameters& p, std::span<const HandWaypoint> path) {
  const double impedance[] = {p.stiffness_N_per_m,    p.damping_Ns_per_m,    p.mass_kg,
                              p.stiffness_Nm_per_rad, p.damping_Nms_per_rad, p.inertia_kg_m2};
  for (const double value : impedance)
    if (!is_finite_and_at_least(value, 0.0))
      return Status::error("hand: stiffness, damping, mass and inertia must be finite and not negative, one is " +
                           std::to_string(value));
  for (std::size_t i = 0; i < path.size(); ++i) {
    const std::string which = "hand: way point " + std::to_string(i + 1);
    if (!is_finite(path[i].position_m) || !is_finite(path[i].rotation_vector_rad) ||
        !is_finite_and_at_least(path[i].time_s, 0.0))
      return Status::error(which + ": time, position and rotation must be finite, the time not negative");
    if (i > 0 && path[i].time_s <= path[i - 1].time_s)
      return Status::error(which + ": its time " + std::to_string(path[i].time_s) + " s must be after " +
                           std::to_string(path[i - 1].time_s) + " s, the one before");
  }
  if (p.repeat && path.size() > 1 &&
      !(path.front().position_m == path.back().position_m &&
        path.front().rotation_vector_rad == path.back().rotation_vector_rad))
    return Status::error("hand: a path that repeats must end in the pose in which it starts");
  return Status::good();
}

HandTarget HandModel::target_at(double time_s) const noexcept {
  double t = time_s;
  const double length_s = end_s_ - start_s_;
  if (parameters_.repeat && t > end_s_ && length_s > 0.0) {
    const double into = t - start_s_;
    t = start_s_ + (into - length_s * std::floor(into / length_s));
  }
  if (segments_.empty() || t <= start_s_) return first_;
  if (t >= end_s_) return last_;

  const auto after = std::upper_bound(segments_.begin(), segments_.end(), t,
                                      [](double value, const Segment& s) { return value < s.start_s; });
  return (after - 1)->at(t);
}

double HandModel::return_s(const Posed& from) const noexcept {
  const Segment way = Segment::between(from, first_.pose, 0, 1);
  return kReturnStart_s + std::max(norm(way.move) / kReturnSpeed_m_per_s, norm(way.turn) / kReturnSpeed_rad_per_s);
}

HandTarget HandModel::returning_from(const Posed& from, double time_s) const noexcept {
  const double duration_s = return_s(from);
  return time_s < duration_s ? Segment::between(from, first_.pose, 0, duration_s).at(time_s) : first_;
}

HandModel::Segment HandModel::Segment::between(const Posed& from, const Posed& to, double start_s,
                                               double duration_s) noexcept {
  return {.start_s = start_s,
          .duration_s = duration_s,
          .position = from.position,
          .move = to.position - from.position,
          .rotation = from.rotation,
          .turn = rotation_vector_of(to.rotation * conjugate(from.rotation))};
}

HandTarget HandModel::Segment::at(double time_s) const noexcept {
  const double u = std::min((time_s - start_s) / duration_s, 1.0);
  switch (motion) {
    case haptics::HandMotion::kLinear:
      return linear_at(u);
    case haptics::HandMotion::kCubic:
      return cubic_at(u);
    case haptics::HandMotion::kSmoothStep:
      break;
  }
  return smooth_at(u);
}

HandTarget HandModel::Segment::smooth_at(double u) const noexcept {
  const SmoothStep step = smooth_step(u);
  const double rate = step.rate / duration_s;
  return {{position + move * step.share, normalized(quat_from_rotation_vector(turn * step.share) * rotation)},
          {move * rate, turn * rate}};
}

HandTarget HandModel::Segment::linear_at(double u) const noexcept {
  const double rate = 1.0 / duration_s;
  return {{position + move * u, normalized(quat_from_rotation_vector(turn * u) * rotation)},
          {move * rate, turn * rate}};
}

HandTarget HandModel::Segment::cubic_at(double u) const noexcept {
  // Cubic Hermite basis of the displacement and of the velocities at the start and the end; their derivatives by u.
  const double way = u * u * (3.0 - 2.0 * u), start = u * (1.0 - u) * (1.0 - u), end = u * u * (u - 1.0);
  const double way_rate = 6.0 * u * (1.0 - u), start_rate = (1.0 - u) * (1.0 - 3.0 * u), end_rate = u * (3.0 * u - 2.0);
  const auto value = [&](const Vec3d& move_by, const Vec3d& v0, const Vec3d& v1) {
    return move_by * way + (v0 * start + v1 * end) * duration_s;
  };
  const auto derivative = [&](const Vec3d& move_by, const Vec3d& v0, const Vec3d& v1) {
    return move_by * (way_rate / duration_s) + v0 * start_rate + v1 * end_rate;
  };
  const Vec3d turned = value(turn, start_turn_rate, end_turn_rate);
  return {
      {position + value(move, start_velocity, end_velocity), normalized(quat_from_rotation_vector(turned) * rotation)},
      {derivative(move, start_velocity, end_velocity),
       angular_velocity_of(turned, derivative(turn, start_turn_rate, end_turn_rate))}};
}

}  // namespace tactus::hal
