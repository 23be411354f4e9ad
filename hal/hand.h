// A simulated hand: an arm's impedance that follows a scripted target and holds the device's tool.
//
// Force on the tool: k (x_target - x) + c (v_target - v), the same in rotation (2 sin(angle / 2) stands for the angle);
// the hand's mass is added to the device's, for the hand holds it rigidly. How the target moves between way points:
//   kSmoothStep  position, speed and acceleration continuous; it rests for an instant at each way point
//   kLinear      straight on at a constant speed, which steps at each way point
//   kCubic       through each way point with the velocity that it names: position and speed continuous (Hermite)
// Rotations go the short way, by the rotation vector from one to the next. Frame: the device's.
// Units: SI. Thread: construction [setup] (copies the path); the rest [rt], no allocation, a binary search over the
// path.
#pragma once

#include <span>
#include <vector>

#include "rt/base/result.h"
#include "rt/base/rotation_vector.h"
#include "rt/base/spatial.h"

namespace tactus::hal {

using tactus::rotation_vector_of;

enum class HandMotion { kSmoothStep, kLinear, kCubic };

struct HandWaypoint {
  double time_s{0};
  Vec3d position_m;
  Vec3d rotation_vector_rad;  // of the tool, about the device's axes
  // Of the target there, in the device's axes; for kCubic alone.
  Vec3d velocity_m_per_s{}, angular_velocity_rad_per_s{};
};

struct HandParameters {
  double stiffness_N_per_m{400}, damping_Ns_per_m{12}, mass_kg{0.5};
  double stiffness_Nm_per_rad{4}, damping_Nms_per_rad{0.1}, inertia_kg_m2{1e-3};
  bool repeat{false};  // the path starts again at its end, whose pose is then that of its start
  HandMotion motion{HandMotion::kSmoothStep};
};

struct HandTarget {
  Posed pose;    // device_from_tool
  Twistd twist;  // m/s, rad/s
};

class HandModel {
 public:
  // A hand that holds still at the origin.
  HandModel() : HandModel(HandParameters{}, {}) {}

  // [setup] `path`: times ascending; an empty one rests at the origin. Check it first.
  HandModel(const HandParameters& parameters, std::span<const HandWaypoint> path);

  // [setup] One line: which way point or parameter is wrong, and what is accepted.
  static Status check(const HandParameters& parameters, std::span<const HandWaypoint> path);

  const HandParameters& parameters() const noexcept { return parameters_; }

  // Before the first way point: the first. After the last: the last, or the path again.
  HandTarget target_at(double time_s) const noexcept;

  // From a pose to where the path starts, along the same smooth step: how long that takes, and where the target is by
  // then. Way and turn are those of a hand that does not hurry.
  double return_s(const Posed& from) const noexcept;
  HandTarget returning_from(const Posed& from, double time_s) const noexcept;

 private:
  struct Segment {
    double start_s, duration_s;
    Vec3d position, move;  // m
    Quatd rotation;
    Vec3d turn;  // rad, device axes: from the start's rotation to the end's, the short way
    HandMotion motion{HandMotion::kSmoothStep};
    Vec3d start_velocity{}, end_velocity{};    // m/s; kCubic, as below
    Vec3d start_turn_rate{}, end_turn_rate{};  // rad/s: of the rotation vector from the start's rotation

    static Segment between(const Posed& from, const Posed& to, double start_s, double duration_s) noexcept;
    HandTarget at(double time_s) const noexcept;
    HandTarget smooth_at(double u) const noexcept;  // u: share of the time, 0 to 1, and so below
    HandTarget linear_at(double u) const noexcept;
    HandTarget cubic_at(double u) const noexcept;
  };

  HandParameters parameters_;
  std::vector<Segment> segments_;
  HandTarget first_, last_;
  double start_s_{0}, end_s_{0};
};

}  // namespace tactus::hal
