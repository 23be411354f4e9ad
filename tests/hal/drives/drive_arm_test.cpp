// An arm of drives on simulated drives: poses, forces, start and stop, every fault of a drive, what damping buys.
#include "hal/drives/drive_arm.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "firmware/faults.h"
#include "hal/drives/drive_damping.h"
#include "hal/drives/drive_faults.h"
#include "tests/hal/drives/drive_bench.h"

using namespace tactus;
using namespace tactus::hal;
using namespace tactus::test;
using Catch::Matchers::Contains;
using haptics::DeviceState;
using haptics::ReadStatus;

namespace {

using Bench = DriveBench;

constexpr DriveFamily kFamilies[] = {DriveFamily::kDamiao,    DriveFamily::kCubeMars, DriveFamily::kMiniCheetah,
                                     DriveFamily::kRobStride, DriveFamily::kMoteus,   DriveFamily::kOdrive};

}  // namespace

TEST_CASE("drives: the pose is the plant's, to a quantum, for every family and both arms") {
  for (const DriveFamily family : kFamilies)
    for (const Vec3d& place : {Vec3d{}, Vec3d{0.02, -0.03, 0.01}, Vec3d{-0.04, 0.02, -0.03}}) {
      CAPTURE(codec_of(family).name, place.x);
      Bench bench(point_arm_of(family), held_at(place));
      bench.ticks(50);
      REQUIRE(bench.input.status == ReadStatus::kFresh);
      const Vec3d truth = bench.device->world().plant().pose().position;
      CHECK(norm(truth - place) < 1e-3);
      CHECK(norm(bench.input.sample.device_from_tool.position - truth) <
            2 * bench.profile.properties.position_quantum_m);
    }
  HandParameters parameters;
  const std::vector<HandWaypoint> path = {{0.0, {0.05, 0.02, -0.04}, {0.2, -0.3, 0.4}},
                                          {1.0, {0.05, 0.02, -0.04}, {0.2, -0.3, 0.4}}};
  Bench six(wristed_arm_of_moteus(), HandModel(parameters, path));
  six.ticks(50);
  const Posed truth = six.device->world().plant().pose(), seen = six.input.sample.device_from_tool;
  CHECK(norm(seen.position - truth.position) < 2 * six.profile.properties.position_quantum_m);
  CHECK(norm(rotation_vector_of(seen.rotation * conjugate(truth.rotation))) <
        4 * six.profile.properties.rotation_quantum_rad);
}

TEST_CASE("drives: no drive is enabled before force is requested, nor after the request ends") {
  for (const DriveFamily family : kFamilies) {
    CAPTURE(codec_of(family).name);
    Bench bench(point_arm_of(family));
    CHECK_FALSE(bench.any_enabled());
    bench.want(DeviceState::kIdle, 50);
    CHECK(bench.input.sample.state == DeviceState::kIdle);
    CHECK_FALSE(bench.any_enabled());
    bench.want(DeviceState::kForce, 4);
    CHECK(bench.input.sample.state == DeviceState::kForce);
    bench.ticks(family == DriveFamily::kMoteus ? kMoteusStart : 0);
    CHECK(bench.any_enabled());
    bench.want(DeviceState::kIdle, 4);
    CHECK_FALSE(bench.any_enabled());
    for (unsigned i = 0; i < 4 + kMoteusStart; ++i) {
      bench.want(DeviceState::kForce, 1);
      CHECK(bench.force_N() < 0.05);  // what was kept from before is not acted upon
    }
  }
}

TEST_CASE("drives: the force at the tool is within two per cent of the command in every direction") {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (const DriveFamily family : kFamilies) {
    double worst = 0, worst_mean = 0;
    Bench bench(point_arm_of(family), held_at({0.02, 0.01, -0.02}));
    bench.want(DeviceState::kForce);
    const double force_N = bench.profile.properties.continuous_force_N;
    for (int i = 0; i < 100; ++i) {
      bench.command.wrench.force =
          normalized_or(Vec3d{uniform(random), uniform(random), uniform(random)}, Vec3d{1, 0, 0}) * force_N;
      bench.ticks(30);
      Vec3d mean;
      for (int k = 0; k < 2; ++k) {
        bench.tick();
        const Vec3d made = bench.device->world().commanded_wrench().force;
        worst = std::max(worst, norm(made - bench.command.wrench.force) / force_N);
        mean += made * 0.5;
      }
      worst_mean = std::max(worst_mean, norm(mean - bench.command.wrench.force) / force_N);
    }
    CAPTURE(codec_of(family).name, worst, worst_mean);
    CHECK(worst < 0.02);
    CHECK(worst_mean < 0.02);
  }
}

TEST_CASE("drives: with zero force commanded the force is zero, or zero in the mean where a frame has no zero") {
  for (const DriveFamily family : kFamilies) {
    CAPTURE(codec_of(family).name);
    Bench bench(point_arm_of(family), held_at({}));
    bench.want(DeviceState::kForce);
    Vec3d mean;
    double most = 0;
    for (int i = 0; i < 100; ++i) {
      bench.tick();
      const Vec3d force = bench.device->world().commanded_wrench().force;
      mean += force * 0.01;
      most = std::max(most, norm(force));
    }
    const bool exact = family == DriveFamily::kRobStride || codec_of(family).has_float_position;
    CHECK(norm(mean) < 1e-9);
    if (exact)
      CHECK(most < 1e-12);
    else
      CHECK(most > 0);
  }
}

TEST_CASE("drives: an effort rises no faster than it may, and falls at once") {
  Bench bench(point_arm_of(DriveFamily::kMoteus), held_at({}));
  bench.want(DeviceState::kForce, kMoteusStart);
  bench.command.wrench.force = {bench.profile.properties.max_force_N, 0, 0};
  double before = 0;
  const double slope_N = 0.25 * bench.profile.properties.max_force_N * 2;  // the worst axis may be twice as strong
  for (int i = 0; i < 10; ++i) {
    bench.tick();
    CHECK(bench.force_N() - before < slope_N);
    before = bench.force_N();
  }
  CHECK(before == Approx(bench.profile.properties.max_force_N).epsilon(0.01));
  bench.command.wrench = {};
  bench.tick();
  CHECK(bench.force_N() == 0.0);
}

TEST_CASE("drives: a set of answers with one missing, late or short is no sample, two answers are one") {
  for (const DriveFamily family : {DriveFamily::kDamiao, DriveFamily::kRobStride, DriveFamily::kMoteus}) {
    CAPTURE(codec_of(family).name);
    const auto status_with = [&](DriveFaultKind kind) {
      Bench bench(point_arm_of(family));
      bench.want(DeviceState::kForce, 20);
      bench.inject(kind);
      bench.ticks(2);
      const ReadStatus status = bench.input.status;
      bench.ticks(5);
      CHECK(bench.input.status == ReadStatus::kFresh);
      CHECK(bench.input.sample.state == DeviceState::kForce);
      return status;
    };
    CHECK(status_with(DriveFaultKind::kTwice) == ReadStatus::kFresh);
    CHECK(status_with(DriveFaultKind::kShort) == ReadStatus::kCorrupt);
    for (const DriveFaultKind kind :
         {DriveFaultKind::kNoAnswer, DriveFaultKind::kNoCommand, DriveFaultKind::kLate, DriveFaultKind::kUndefinedId})
      CHECK(status_with(kind) == ReadStatus::kMissing);
  }
}

TEST_CASE("drives: what a drive does by itself latches a brake, is explained, and is left by a re-arm") {
  struct Case {
    DriveFaultKind kind;
    std::uint32_t number;
    const char* words;
  };
  const Case cases[] = {{DriveFaultKind::kFaultFlag, kDriveReportsFault + 1, "the drive of axis 1 reports a fault: "},
                        {DriveFaultKind::kDisabled, kDriveLeftForce + 1, "axis 1 is not enabled any more"},
                        {DriveFaultKind::kRestarted, kDriveLeftForce + 1, "axis 1 is not enabled any more"}};
  for (const DriveFamily family : {DriveFamily::kDamiao, DriveFamily::kRobStride})
    for (const Case& c : cases) {
      CAPTURE(codec_of(family).name, c.number);
      Bench bench(point_arm_of(family));
      bench.command.wrench.force = {2, 0, 0};
      bench.want(DeviceState::kForce, 20);
      REQUIRE(bench.force_N() > 1.9);
      bench.inject(c.kind);
      bench.ticks(4);
      CHECK(bench.input.sample.state == DeviceState::kBrake);
      CHECK(number_of_drive_fault(bench.input.sample.device_fault) == c.number);
      CHECK_THAT(describe_drive_fault(bench.input.sample.device_fault), Contains(c.words) && Contains("re-arm"));
      CHECK(bench.force_N() < 0.05);
      bench.ticks(50);  // the host goes on wanting force
      CHECK(bench.input.sample.state == DeviceState::kBrake);
      CHECK(bench.force_N() < 0.05);
      bench.rearm();
      CHECK(bench.input.sample.state == DeviceState::kForce);
      CHECK(bench.input.sample.device_fault == 0);
      CHECK(bench.force_N() > 1.9);
    }
}

TEST_CASE("drives: a drive that stays silent latches a brake with the tenth period, and not before") {
  Bench bench(point_arm_of(DriveFamily::kMoteus));
  bench.want(DeviceState::kForce, 20);
  bench.inject(DriveFaultKind::kNoAnswer, 2, 30);
  bench.ticks(10);
  CHECK(bench.input.status == ReadStatus::kMissing);
  CHECK(bench.input.sample.state == DeviceState::kForce);
  bench.ticks(3);
  CHECK(bench.input.sample.state == DeviceState::kBrake);
  CHECK(bench.input.sample.device_fault == kDriveSilent + 2);
}

TEST_CASE("drives: a bus that is off reads as disconnected, and the drives' own watchdogs end the force") {
  for (const DriveFamily family : {DriveFamily::kDamiao, DriveFamily::kRobStride, DriveFamily::kMoteus}) {
    CAPTURE(codec_of(family).name);
    Bench bench(point_arm_of(family));
    bench.command.wrench.force = {2, 0, 0};
    bench.want(DeviceState::kForce, 20);
    bench.inject(DriveFaultKind::kBusOff, kAllAxes, 50);
    unsigned periods_with_force = 0;
    for (int i = 0; i < 50; ++i) {
      bench.tick();
      CHECK(bench.input.status == ReadStatus::kDisconnected);
      periods_with_force += bench.force_N() > 0;
    }
    CHECK(periods_with_force <= 11);  // 10 ms, and the period in which they end
    bench.ticks(5);
    CHECK(bench.input.status == ReadStatus::kFresh);
    CHECK(bench.input.sample.state == DeviceState::kBrake);
    bench.rearm();
    CHECK(bench.input.sample.state == DeviceState::kForce);
    bench.ticks(family == DriveFamily::kMoteus ? kMoteusStart : 0);
    CHECK(bench.force_N() > 1.9);
  }
}

TEST_CASE("drives: when the whole process stops, every family's watchdog ends the force after 10 ms") {
  for (const DriveFamily family : kFamilies) {
    if (family == DriveFamily::kCubeMars || family == DriveFamily::kMiniCheetah) continue;  // theirs are their makers'
    CAPTURE(codec_of(family).name);
    Bench bench(point_arm_of(family));
    bench.command.wrench.force = {2, 0, 0};
    bench.want(DeviceState::kForce, 20);
    REQUIRE(bench.force_N() > 1.9);
    for (int i = 0; i < 11; ++i) bench.device->world().advance();
    CHECK(bench.force_N() == 0.0);
  }
}

TEST_CASE("drives: nothing is enabled by a drive's lost disable command") {
  Bench bench(point_arm_of(DriveFamily::kDamiao));
  bench.want(DeviceState::kForce, 20);
  bench.command.wanted = DeviceState::kIdle;
  bench.inject(DriveFaultKind::kNoCommand, 1, 3);  // without torque, and the two after it
  bench.ticks(3);
  CHECK(bench.device->world().drive(1).enabled());
  bench.ticks(4);
  CHECK_FALSE(bench.any_enabled());
}

TEST_CASE("drives: a position that wraps is far from where the tool was") {
  Bench bench(point_arm_of(DriveFamily::kDamiao));
  bench.want(DeviceState::kForce, 20);
  const Vec3d before = bench.input.sample.device_from_tool.position;
  bench.inject(DriveFaultKind::kWrapped, 1, 3);
  bench.ticks(3);
  // The guard of the loop refuses it: nothing moves so fast.
  CHECK(norm(bench.input.sample.device_from_tool.position - before) >
        10 * bench.profile.properties.max_speed_m_per_s * 1e-3);
}

TEST_CASE("drives: a saturated speed field changes nothing, as the speed is taken from the positions") {
  Bench bench(point_arm_of(DriveFamily::kDamiao));
  bench.command.wrench.force = {1, 0, 0};
  bench.want(DeviceState::kForce, 20);
  bench.inject(DriveFaultKind::kSpeed, kAllAxes, 50);
  bench.ticks(50);
  CHECK(bench.input.status == ReadStatus::kFresh);
  CHECK(bench.input.sample.state == DeviceState::kForce);
}

TEST_CASE(
    "drives: a drive that answers without the torque that it is sent brakes the arm, whatever it tells of itself") {
  for (const DriveFamily family : {DriveFamily::kCubeMars, DriveFamily::kMiniCheetah}) {
    CAPTURE(codec_of(family).name);
    Bench bench(point_arm_of(family));
    bench.command.wrench.force = {2, 0, 2};
    bench.want(DeviceState::kForce, 20);
    REQUIRE(bench.force_N() > 1.9);
    bench.inject(DriveFaultKind::kRestarted);
    bench.ticks(25);  // a window that had begun, and the next
    CHECK(bench.input.sample.state == DeviceState::kBrake);
    CHECK(bench.input.sample.device_fault == kDriveLacksTorque + 1);
    CHECK_THAT(describe_drive_fault(bench.input.sample.device_fault),
               Contains("axis 1") && Contains("without the torque") && Contains("re-arm"));
    bench.rearm();
    CHECK(bench.input.sample.state == DeviceState::kForce);
    CHECK(bench.force_N() > 1.9);
  }
}

TEST_CASE("drives: a force that turns, fades and stops is no lack of torque, nor is the drives' own damping") {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> uniform(-4, 4);
  for (const DriveFamily family : kFamilies) {
    CAPTURE(codec_of(family).name);
    HandParameters hand;
    const std::vector<HandWaypoint> path = {
        {0.0, {0.05, 0, 0}, {}}, {0.15, {-0.05, 0.03, 0.02}, {}}, {0.3, {0.05, 0, 0}, {}}};
    hand.repeat = true;
    Bench bench(point_arm_of(family, family == DriveFamily::kOdrive ? 0 : 0.05), HandModel(hand, path));
    bench.want(DeviceState::kForce);
    for (int i = 0; i < 2000; ++i) {
      if (i % (1 + i % 7) == 0) bench.command.wrench.force = {uniform(random), uniform(random), uniform(random)};
      bench.tick();
    }
    CHECK(bench.input.sample.state == DeviceState::kForce);
    CHECK(bench.input.sample.device_fault == 0);
  }
}

TEST_CASE("drives: six ODrives on two buses run from the first tick on, and the hand has not moved before it") {
  DeviceDescription d = wristed_arm_of_moteus();
  d.drives.family = DriveFamily::kOdrive;
  d.drives.data_bit_per_s = 0;
  for (DriveAxis& axis : d.drives.axes) axis.brake_damping_Nms_per_rad = 0;
  set_drive_quanta(d);
  const std::vector<HandWaypoint> path = {{0.0, {0, 0, 0.05}, {}}, {1.0, {0, 0, -0.05}, {}}};
  Bench bench(d, HandModel(HandParameters{}, path));
  for (int i = 0; i < 300; ++i) {
    bench.tick();
    REQUIRE(bench.input.status == ReadStatus::kFresh);
    if (i == 0) CHECK(bench.input.sample.device_from_tool.position.z == Approx(0.05).margin(1e-3));
  }
  bench.want(DeviceState::kForce, 150);
  CHECK(bench.input.sample.state == DeviceState::kForce);
}

TEST_CASE("drives: damping in the drives is damping at the tool, at least as much as the gain check counts") {
  const double damping = 0.01;
  const DeviceDescription with = point_arm_of(DriveFamily::kMoteus, damping);
  const DeviceProfile profile = drive_profile(with);
  const double counted = profile.drive_damping_Ns_per_m;
  // A point arm's link of 0.16 m with 2:1 capstans: 4 d / l^2 along a link's turn, the least over the workspace less.
  CHECK(counted < 4 * damping / (0.16 * 0.16));
  CHECK(counted > 0.2 * 4 * damping / (0.16 * 0.16));
  CHECK(profile.properties.damping_Ns_per_m == Approx(with.damping_Ns_per_m + counted));
  std::mt19937 random(2);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const AxisVector axes = axis_damping(with.drives);
  for (int i = 0; i < 2000; ++i) {
    const auto direction = [&] {
      return normalized_or(Vec3d{uniform(random), uniform(random), uniform(random)}, Vec3d{1, 0, 0});
    };
    const AxisVector q = coordinates_of(profile.kinematics, {direction() * (0.08 * std::abs(uniform(random))), {}});
    const AxisVector rate = profile.kinematics.rates_of(q, {direction(), {}});
    double power = 0;
    for (unsigned k = 0; k < 3; ++k) power += axes[k] * rate[k] * rate[k];
    REQUIRE(power >= counted);
  }
}

namespace {

// The stiffest wall on which the vibration of a soft hand's impact decays, N/m.
double stiffest_wall_N_per_m(double drive_damping_Nms_per_rad) {
  DeviceDescription d = point_arm_of(DriveFamily::kMoteus, drive_damping_Nms_per_rad);
  d.coulomb_friction_N = 0;  // nothing but viscous damping resists
  HandParameters soft;
  soft.stiffness_N_per_m = 30;
  soft.damping_Ns_per_m = 0.1;
  soft.mass_kg = 0.05;
  const std::vector<HandWaypoint> path = {{0.0, {0, 0, 0.005}, {}}, {0.2, {0, 0, -0.03}, {}}};
  const auto is_stable = [&](double stiffness) {
    Bench bench(d, HandModel(soft, path));
    bench.want(DeviceState::kForce);
    double before = 0, after = 0;  // fastest motion in two windows
    for (int i = 0; i < 1500; ++i) {
      bench.device->read(bench.input);
      const double depth = -bench.input.sample.device_from_tool.position.z;
      bench.command.wrench.force.z = depth > 0 ? std::min(stiffness * depth, 8.0) : 0.0;
      bench.device->write(bench.command);
      const double speed = std::abs(bench.device->world().plant().twist().linear.z);
      if (i >= 600 && i < 900) before = std::max(before, speed);
      if (i >= 1200) after = std::max(after, speed);
    }
    return after < before || after < 0.003;
  };
  double low = 10, high = 20000;
  REQUIRE(is_stable(low));
  for (int i = 0; i < 10; ++i) (is_stable(std::sqrt(low * high)) ? low : high) = std::sqrt(low * high);
  return low;
}

}  // namespace

TEST_CASE("drives: damping in the drives buys stiffness, as much as the gain check counts") {
  const auto damping_at_tool = [](double drive_damping) {
    return drive_profile(point_arm_of(DriveFamily::kMoteus, drive_damping)).properties.damping_Ns_per_m;
  };
  // K < b / (T / 2 + t_d): with T = t_d = 1 ms.
  const double bound_without = damping_at_tool(0) / 1.5e-3, bound_with = damping_at_tool(0.02) / 1.5e-3;
  const double without = stiffest_wall_N_per_m(0), with = stiffest_wall_N_per_m(0.02);
  WARN("stiffest wall without damping in the drives " << without << " N/m (bound " << bound_without << "), with "
                                                      << with << " N/m (bound " << bound_with << ")");
  CHECK(without >= bound_without);
  CHECK(with >= bound_with);
  CHECK(with / without > 2);
}
