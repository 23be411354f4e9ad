// What is asked of drives before they get force, and asked again before a re-arm; and their faults in words.
#include "hal/drives/drive_setup.h"

#include "hal/drives/drive_faults.h"
#include "tests/hal/drives/drive_arms.h"

using namespace tactus;
using namespace tactus::hal;
using namespace tactus::test;
using Catch::Matchers::Contains;

namespace {

// Three simulated drives of a family, prepared as before a run.
struct PreparedDrives {
  DeviceDescription described;
  SimulatedDrives world{drive_profile(described), HandModel(), kDrivePeriod_ns};
  DriveBuses buses{world.make_buses()};
  std::vector<std::string> identities;

  explicit PreparedDrives(DriveFamily family) : described(point_arm_of(family)) {
    auto prepared = prepare_drives(described.drives, buses);
    REQUIRE(prepared.ok());
    identities = std::move(prepared).value();
  }
  // The comparison that precedes a re-arm.
  Status compare() { return compare_drives(described.drives, buses, identities); }
};

}  // namespace

TEST_CASE("drives: preparing refuses what does not fit the description, by axis, with what to do") {
  const auto refusal = [](DeviceDescription described, const DeviceDescription& real) {
    // The simulated drives follow `real`; the arm is opened with `described`.
    SimulatedDrives world(drive_profile(real), HandModel(), kDrivePeriod_ns);
    const DriveBuses buses = world.make_buses();
    return prepare_drives(described.drives, buses).message();
  };
  const DeviceDescription damiao = point_arm_of(DriveFamily::kDamiao);
  CHECK(refusal(damiao, damiao).empty());
  DeviceDescription other = damiao;
  other.drives.axes[2].torque_range_Nm = 4;
  CHECK_THAT(refusal(other, damiao), Contains("axis 2 (drive 3)") && Contains("register 23 is 3") && Contains("is 4"));
  other = damiao;
  other.drives.axes[0].id = 9;
  CHECK_THAT(refusal(other, damiao), Contains("axis 0 (drive 9)") && Contains("does not answer"));
  other = damiao;
  other.drives.axes[1].answer_id = 0x21;
  CHECK_THAT(refusal(other, damiao), Contains("axis 1") && Contains("does not answer"));
  const DeviceDescription moteus = point_arm_of(DriveFamily::kMoteus);
  other = moteus;
  other.drives.axes[1].id = 77;
  CHECK_THAT(refusal(other, moteus), Contains("axis 1 (drive 77)") && Contains("does not answer"));
}

TEST_CASE("drives: one without a working watchdog is refused, where that can be provoked") {
  for (const DriveFamily family : {DriveFamily::kMoteus, DriveFamily::kOdrive}) {
    const DeviceDescription d = point_arm_of(family);
    SimulatedDrives world(drive_profile(d), HandModel(), kDrivePeriod_ns);
    const DriveBuses buses = world.make_buses();
    CHECK(prepare_drives(d.drives, buses).ok());
    world.drive(2).keep_no_watchdog();
    const auto refused = prepare_drives(d.drives, buses);
    REQUIRE_FALSE(refused.ok());
    CHECK_THAT(refused.message(), Contains("axis 2") && Contains("watchdog") && Contains("maker's tool"));
    for (unsigned i = 0; i < 3; ++i) CHECK_FALSE(world.drive(i).enabled());
  }
}

TEST_CASE("drives: a moteus that still is in a time-out, with a watchdog that does not act any more, is refused") {
  const DeviceDescription d = point_arm_of(DriveFamily::kMoteus);
  SimulatedDrives world(drive_profile(d), HandModel(), kDrivePeriod_ns);
  const DriveBuses buses = world.make_buses();
  for (int i = 0; i < 20; ++i) {  // an earlier program, which was killed
    world.hear(0, codec_of(d.drives.family).encode(d.drives.axes[1], {.action = DriveAction::kEnable}));
    world.advance();
  }
  for (int i = 0; i < 20; ++i) world.advance();
  world.restart_clock();
  CHECK(prepare_drives(d.drives, buses).ok());
  for (int i = 0; i < 20; ++i) {
    world.hear(0, codec_of(d.drives.family).encode(d.drives.axes[1], {.action = DriveAction::kEnable}));
    world.advance();
  }
  for (int i = 0; i < 20; ++i) world.advance();
  world.restart_clock();
  world.drive(1).keep_no_watchdog();
  CHECK_THAT(prepare_drives(d.drives, buses).message(), Contains("axis 1") && Contains("its watchdog did not act"));
}

TEST_CASE("drives: a moteus that takes 30 ms to position mode is prepared, one that does not get there is refused") {
  const DeviceDescription d = point_arm_of(DriveFamily::kMoteus);
  SimulatedDrives world(drive_profile(d), HandModel(), kDrivePeriod_ns);
  const DriveBuses buses = world.make_buses();
  world.drive(1).set_start(0.03);
  CHECK(prepare_drives(d.drives, buses).message().empty());
  world.drive(1).set_start(1);
  CHECK_THAT(prepare_drives(d.drives, buses).message(), Contains("axis 1") && Contains("into position mode"));
  CHECK_FALSE(world.drive(1).enabled());
}

TEST_CASE("drives: a drive that restarted has lost its watchdog, and is found out before force comes back") {
  for (const DriveFamily family : {DriveFamily::kDamiao, DriveFamily::kRobStride}) {
    CAPTURE(codec_of(family).name);
    PreparedDrives drives(family);
    CHECK(drives.compare().ok());
    drives.world.drive(1).restart();
    const Status compared = drives.compare();
    REQUIRE_FALSE(compared.ok());
    CHECK_THAT(compared.message(), Contains("axis 1") && Contains("start again"));
  }
}

TEST_CASE("drives: another drive in the place of one is found out before force comes back, by its serial number") {
  for (const DriveFamily family : {DriveFamily::kRobStride, DriveFamily::kMoteus}) {
    CAPTURE(codec_of(family).name);
    PreparedDrives drives(family);
    drives.world.drive(2).set_serial(0x1234);
    const Status compared = drives.compare();
    REQUIRE_FALSE(compared.ok());
    CHECK_THAT(compared.message(), Contains("axis 2 (drive 3)") && Contains("00001234") && Contains("abcd0000") &&
                                       Contains("this run began with"));
  }
}

TEST_CASE("drives: a moteus whose time-out would not brake is refused, with the setting") {
  const DeviceDescription d = point_arm_of(DriveFamily::kMoteus);
  SimulatedDrives world(drive_profile(d), HandModel(), kDrivePeriod_ns);
  const DriveBuses buses = world.make_buses();
  world.drive(1).set_timeout_mode(12);
  CHECK_THAT(prepare_drives(d.drives, buses).message(),
             Contains("axis 1") && Contains("servo.timeout_mode is 12") && Contains("conf set servo.timeout_mode 15"));
  world.drive(1).set_timeout_mode(15);
  CHECK(prepare_drives(d.drives, buses).ok());
}

TEST_CASE("drives: an ODrive whose watchdog is longer than the silence is refused, from 20 to 200 ms") {
  const DeviceDescription d = point_arm_of(DriveFamily::kOdrive);
  for (const double watchdog_s : {0.02, 0.05, 0.1, 0.2}) {
    SimulatedDrives world(drive_profile(d), HandModel(), kDrivePeriod_ns);
    const DriveBuses buses = world.make_buses();
    world.drive(1).set_watchdog(watchdog_s);
    CAPTURE(watchdog_s);
    CHECK_THAT(prepare_drives(d.drives, buses).message(),
               Contains("axis 1") && Contains("longer than 15 ms") && Contains("watchdog_timeout = 0.01"));
    for (unsigned i = 0; i < 3; ++i) CHECK_FALSE(world.drive(i).enabled());
  }
}

TEST_CASE("drives: a drive's own code is kept with its fault, in words where they are known") {
  const auto words = [](DriveFamily family, std::uint32_t code) {
    const std::uint32_t fault = drive_fault_of(4, family, code);
    CHECK(number_of_drive_fault(fault) == kDriveReportsFault + 4);
    return describe_drive_fault(fault);
  };
  CHECK_THAT(words(DriveFamily::kDamiao, 0xa), Contains("axis 4 reports a fault: status 10, over-current"));
  CHECK_THAT(words(DriveFamily::kCubeMars, 5), Contains("error 5, encoder"));
  CHECK_THAT(words(DriveFamily::kRobStride, 0x10), Contains("fault bits 0x10, stall or Hall"));
  for (std::uint32_t code = 32; code <= 48; ++code)  // those of the maker's reference
    CHECK_THAT(words(DriveFamily::kMoteus, code), Contains("fault " + std::to_string(code) + ", "));
  CHECK_THAT(words(DriveFamily::kMoteus, 39), Contains("started outside of servopos.position_min"));
  CHECK_THAT(words(DriveFamily::kMoteus, 49), Contains("fault 49;"));
  CHECK_THAT(words(DriveFamily::kOdrive, 0x800), Contains("error bits 0x800, its watchdog"));
  CHECK_THAT(words(DriveFamily::kOdrive, 1u << 31), Contains("error bits 0x80000000;"));
}
