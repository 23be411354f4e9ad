#include "rt/calibration/calibration_worlds.h"

#include <numbers>

#include "rt/base/clock.h"

namespace tactus::loop {
namespace {

using haptics::WorldSnapshot;
using physics::Shape;

constexpr double kHalf_m = 0.05;

LoopConfig make_config(SyntheticWorld kind) {
  LoopConfig config;
  auto& sub = config.sub_world;
  sub.ratio = 1u << 30;  // never late
  sub.step.dt = config.period_s;
  if (kind == SyntheticWorld::kSearched) sub.step.recycle_tolerance_m = 0;
  constexpr std::uint32_t n = kCalibrationBodies;
  sub.capacities = {.bodies = n, .fixed_bodies = 1, .pairs = 16 * n, .contacts = 10 * n, .border_contacts = 2 * n};
  return config;
}

// Bodies in a row, so that the only pairs are neighbours. kGap_m is below the contact margin of 0.5 mm, so neighbours
// are contacts. kApart: boxes turned by 45 degrees about z and placed along the diagonal have overlapping bounds, but
// faces further apart than the margin, which is detected at once and stays valid as nothing moves. Boxes that met at an
// edge would need a full comparison instead, without a contact.
constexpr double kGap_m = 0.45e-3, kApart_m = 3.5e-3;

physics::Body make_body(SyntheticWorld kind, std::uint32_t i) {
  constexpr double kDiagonal = std::numbers::sqrt2 / 2;
  const auto shape = kind == SyntheticWorld::kBalls ? Shape::sphere(kHalf_m) : Shape::box({kHalf_m, kHalf_m, kHalf_m});
  Vec3d step{2 * kHalf_m + kGap_m, 0, 0};
  Quatd rotation;
  if (kind == SyntheticWorld::kFree || kind == SyntheticWorld::kBordered) step = {4 * kHalf_m, 0, 0};
  if (kind == SyntheticWorld::kApart) {
    step = kDiagonal * (2 * kHalf_m + kApart_m) * Vec3d{1, 1, 0};
    rotation = quat_from_rotation_vector(Vec3d{0, 0, std::numbers::pi / 4});
  }
  return physics::make_dynamic_body(i, shape, 1.0, 0.5, {static_cast<double>(i) * step, rotation});
}

// Each body stands on two points of outside bodies, one outside body per point.
haptics::BorderPoint make_border_point(std::uint32_t i) {
  haptics::BorderPoint point;
  point.member = i % kCalibrationBodies;
  point.outside = kCalibrationBodies + i;
  point.feature = i;
  point.normal = {0, 0, 1};
  point.member_anchor = {i < kCalibrationBodies ? kHalf_m : -kHalf_m, 0, -kHalf_m};
  point.friction = 0.5;
  point.outside_inverse_mass = 1;
  point.outside_point = make_body(SyntheticWorld::kBordered, point.member).motion.pose.position + point.member_anchor;
  return point;
}

// The outside body of the point: as heavy as the members, at rest, without load.
haptics::OutsideBody make_outside(const haptics::BorderPoint& point) {
  haptics::OutsideBody body;
  body.id = point.outside;
  body.centre = point.outside_point - Vec3d{0, 0, kHalf_m};
  body.admittance.linear = SymMat3d::identity(1);
  body.admittance.angular = SymMat3d::identity(600);
  return body;
}

std::unique_ptr<WorldSnapshot> make_snapshot(SyntheticWorld kind, std::uint32_t members, std::uint32_t first_joiner) {
  auto snapshot = std::make_unique<WorldSnapshot>();
  for (std::uint32_t i = 0; i < members; ++i) {
    (void)snapshot->members.try_push(i);
    if (i >= first_joiner) (void)snapshot->joiners.try_push(make_body(kind, i));
  }
  if (kind == SyntheticWorld::kBordered)
    for (std::uint32_t i = 0; i < 2 * kCalibrationBodies; ++i) {
      const haptics::BorderPoint point = make_border_point(i);
      (void)snapshot->border.try_push(point);
      (void)snapshot->outside.try_push(make_outside(point));
    }
  return snapshot;
}

}  // namespace

CalibrationWorld::CalibrationWorld(SyntheticWorld kind)
    : loop_(make_config(kind), {}), report_(std::make_unique<haptics::SubWorldReport>()) {
  const std::uint32_t members = kind == SyntheticWorld::kLone ? 1 : kCalibrationBodies;
  in_.sink.report = report_.get();
  in_.device.status = haptics::ReadStatus::kFresh;
  in_.device.sample.state = haptics::DeviceState::kIdle;
  (void)tick(1, make_snapshot(kind, members, 0).get());
  none_new_ = make_snapshot(kind, members, members);
  half_ = make_snapshot(kind, members / 2, members);
  all_ = make_snapshot(kind, members, members / 2);
}

TimedWork CalibrationWorld::tick(std::uint32_t sub_steps, const WorldSnapshot* snapshot) {
  ++in_.device.sample.sequence;
  in_.device.sample.device_time_ns += 1'000'000;
  in_.sub_steps = sub_steps;
  in_.snapshot = snapshot;
  const std::int64_t began_ns = MonotonicClock::now_ns();
  loop_.tick(in_, out_);
  const auto ns = static_cast<double>(MonotonicClock::now_ns() - began_ns);
  WorkCounts counts = loop_.counts();
  counts.synchronises = snapshot != nullptr;
  counts.joins = snapshot != nullptr ? snapshot->joiners.size() : 0;
  return {counts, sub_steps, ns};
}

TimedWork CalibrationWorld::tick(std::uint32_t sub_steps) { return tick(sub_steps, nullptr); }

TimedWork CalibrationWorld::tick_synchronising(std::uint32_t sub_steps) { return tick(sub_steps, none_new_.get()); }

TimedWork CalibrationWorld::tick_joining(std::uint32_t sub_steps) {
  (void)tick(sub_steps, half_.get());
  return tick(sub_steps, all_.get());
}

}  // namespace tactus::loop
