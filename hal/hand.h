// A simulated hand: an impedance that follows a scripted target and holds the device's tool.
//
// Force on the tool: k (x_target - x) + c (v_target - v), the same in rotation (with 2 sin(angle / 2) for the angle).
// The hand's mass is added to the device's, because the hand holds the tool rigidly. Motion between way points:
// rt/haptics/hand_motion.h. Rotations are interpolated along the shorter way, by the rotation vector from one way point
// to the next. Frame: the device's. Units: SI. Thread: construction [setup] (copies the path); the rest [rt], no
// allocation, a binary search over the path.
#pragma once

#include <span>
#include <vector>

#include "rt/base/result.h"
#include "rt/base/rotation_vector.h"
#include "rt/base/spatial.h"
#include "rt/haptics/hand_motion.h"

namespace tactus::hal {

using tactus::rotation_vector_of;

struct HandWaypoint {
  double time_s{0};
  Vec3d position_m;
  Vec3d rotation_vector_rad;  // of the tool, about the device's axes
  // Of the target at this way point, device frame; used by kCubic only.
  Vec3d velocity_m_per_s{}, angular_velocity_rad_per_s{};
};

struct HandParameters {
  double stiffness_N_per_m{400}, damping_Ns_per_m{12}, mass_kg{0.5};
  double stiffness_Nm_per_rad{4}, damping_Nms_per_rad{0.1}, inertia_kg_m2{1e-3};
  bool repeat{false};  // the path repeats; its last pose must equal its first
  haptics::HandMotion motion{haptics::HandMotion::kSmoothStep};
};

struct HandTarget {
  Posed pose;    // device_from_tool
  Twistd twist;  // m/s, rad/s
};

class HandModel {
 public:
  // A hand at rest at the origin.
  HandModel() : HandModel(HandParameters{}, {}) {}

  // [setup] `path`: ascending times; empty: the hand rests at the origin. Call check() first.
  HandModel(const HandParameters& parameters, std::span<const HandWaypoint> path);

  // [setup] An error is one line: which way point or parameter is wrong, and what is accepted.
  static Status check(const HandParameters& parameters, std::span<const HandWaypoint> path);

  const HandParameters& parameters() const noexcept { return parameters_; }

  // Before the first way point: the first. After the last: the last, or the repeated path.
  HandTarget target_at(double time_s) const noexcept;

  // Return from a pose to the start of the path along a smooth step, at moderate speed: its duration [s], and the
  // target at `time_s` after its beginning.
  double return_s(const Posed& from) const noexcept;
  HandTarget returning_from(const Posed& from, double time_s) const noexcept;

 private:
  struct Segment {
    double start_s, duration_s;
    Vec3d position, move;  // m
    Quatd rotation;
    Vec3d turn;  // rad, device frame: rotation vector from the start's rotation to the end's, the shorter way
    haptics::HandMotion motion{haptics::HandMotion::kSmoothStep};
    Vec3d start_velocity{}, end_velocity{};    // m/s; kCubic, as below
    Vec3d start_turn_rate{}, end_turn_rate{};  // rad/s: derivative of the rotation vector from the start's rotation

    static Segment between(const Posed& from, const Posed& to, double start_s, double duration_s) noexcept;
    HandTarget at(double time_s) const noexcept;
    HandTarget smooth_at(double u) const noexcept;  // u: elapsed time / duration, 0 to 1; also below
    HandTarget linear_at(double u) const noexcept;
    HandTarget cubic_at(double u) const noexcept;
  };

  HandParameters parameters_;
  std::vector<Segment> segments_;
  HandTarget first_, last_;
  double start_s_{0}, end_s_{0};
};

}  // namespace tactus::hal
