// Recovers the signs and offsets with which the drive angles were generated.
#include "tools/device/calibration.h"

#include <catch2/catch.hpp>

#include "hal/device_file.h"
#include "hal/drives/simulated_drives.h"
#include "hal/kinematics/workspace_bounds.h"
#include "rt/text/read_file.h"
#include "tests/support/random.h"
#include "tools/device/free_arm.h"

using namespace tactus;
using namespace tactus::device;
using Catch::Matchers::Contains;

namespace {

const char* const kFiles[] = {TACTUS_SOURCE_DIR "/hal/devices/point_arm_drives.toml",
                              TACTUS_SOURCE_DIR "/hal/devices/wristed_arm_moteus.toml"};

// The angles that drives with these signs, ratios and offsets tell at a pose.
hal::AxisVector angles_at(const hal::DeviceProfile& profile, const Posed& pose) {
  const hal::AxisVector q = hal::coordinates_of(profile.kinematics, pose);
  hal::AxisVector angles{};
  const auto& axes = profile.description.drives.axes;
  for (unsigned i = 0; i < axes.size(); ++i) angles[i] = axes[i].offset_rad + axes[i].sign * axes[i].ratio * q[i];
  return angles;
}

std::vector<HeldPose> all_moves(const hal::DeviceProfile& described, const hal::DeviceProfile& real) {
  std::vector<HeldPose> moves;
  for (const Posed& pose : calibration_poses(described)) moves.push_back({pose, angles_at(real, pose)});
  return moves;
}

}  // namespace

TEST_CASE("any signs and offsets are found, whatever the description said") {
  test::RandomOf<test::Congruential> random(7);
  for (const char* file : kFiles) {
    const auto described = hal::load_device_file(file);
    REQUIRE(described.ok());
    for (unsigned trial = 0; trial < 50; ++trial) {
      hal::DeviceProfile real = described.value();
      for (hal::DriveAxis& axis : real.description.drives.axes) {
        axis.sign = random(-1, 1) < 0 ? -1 : 1;
        axis.offset_rad = random(-3, 3);
      }
      const auto found = calibrate(described.value(), angles_at(real, {}), all_moves(described.value(), real));
      REQUIRE(found.size() == real.description.drives.axes.size());
      for (unsigned i = 0; i < found.size(); ++i) {
        const hal::DriveAxis& axis = real.description.drives.axes[i];
        CHECK(found[i].sign == axis.sign);
        CHECK(found[i].offset_rad == Approx(axis.offset_rad).margin(1e-9));
        CHECK(found[i].ratio_seen == Approx(axis.ratio));
        CHECK(found[i].doubt.empty());
      }
    }
  }
}

TEST_CASE("a wrong ratio and an axis that was not moved are doubtful") {
  const auto described = hal::load_device_file(kFiles[0]);
  REQUIRE(described.ok());
  hal::DeviceProfile real = described.value();
  real.description.drives.axes[1].ratio *= 2;
  const auto found = calibrate(described.value(), angles_at(real, {}), all_moves(described.value(), real));
  CHECK(found[0].doubt.empty());
  CHECK_THAT(found[1].doubt, Contains("the description's ratio is 1"));
  for (const AxisCalibration& axis : calibrate(described.value(), angles_at(real, {}), {}))
    CHECK_THAT(axis.doubt, Contains("its sign is not known"));
}

TEST_CASE("the calibrated text has the new signs and offsets, and every other line as it was") {
  for (const char* file : kFiles) {
    const std::string before = text::read_file(file, hal::kMaxDeviceFileBytes).value();
    const auto described = hal::parse_device_description(before, "before");
    REQUIRE(described.ok());
    std::vector<AxisCalibration> axes;
    for (unsigned i = 0; i < described.value().drives.axes.size(); ++i)
      axes.push_back({.sign = i % 2 == 0 ? -1.0 : 1.0, .offset_rad = 0.125 * i, .ratio_seen = 1, .doubt = {}});
    const std::string once = with_calibration(before, axes);
    const auto after = hal::parse_device_description(once, "after");
    INFO((after.ok() ? "" : after.message()));
    REQUIRE(after.ok());
    hal::DeviceDescription expected = described.value();
    for (unsigned i = 0; i < axes.size(); ++i) {
      expected.drives.axes[i].sign = axes[i].sign;
      expected.drives.axes[i].offset_rad = axes[i].offset_rad;
    }
    CHECK(after.value().drives == expected.drives);
    CHECK(with_calibration(once, axes) == once);
    CHECK(once.find("[link]") != std::string::npos);
  }
}

TEST_CASE("a free arm reports its drives' angles, and names the axis of a drive that is enabled or silent") {
  const auto profile = hal::load_device_file(kFiles[0]);
  REQUIRE(profile.ok());
  hal::SimulatedDrives world(profile.value(), hal::HandModel(), 1'000'000);
  const hal::DriveBuses buses = world.make_buses();
  FreeArm arm(profile.value().description.drives, buses);
  const auto angles = arm.read();
  REQUIRE(angles.ok());
  const hal::AxisVector expected = angles_at(profile.value(), {});
  const double quantum_rad = 2 * profile.value().description.drives.axes[0].position_range_rad / 65535;
  for (unsigned i = 0; i < 3; ++i) CHECK(angles.value()[i] == Approx(expected[i]).margin(1.01 * quantum_rad));
  world.inject({.kind = hal::DriveFaultKind::kNoAnswer, .axis = 1, .tick = world.tick(), .ticks = 1000});
  CHECK_THAT(arm.poll().message(), Contains("axis 1 (drive 2) does not answer"));
}

TEST_CASE("a drive near the end of its range is reported") {
  const hal::DriveAxis axis{.position_range_rad = 4};
  CHECK(range_share(axis, -3.8, 1) == Approx(0.95));
  CHECK(range_share(axis, -1, 2) == Approx(0.5));
  CHECK(range_share({}, -100, 100) == 0);
}
