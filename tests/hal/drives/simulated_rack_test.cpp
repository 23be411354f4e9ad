// Simulated drives apart from their mechanics: one for each axis, as processes of their own have them, against the
// whole arm.
#include "hal/drives/simulated_rack.h"

#include <catch2/catch.hpp>

#include "tests/hal/drives/drive_arms.h"

using namespace tactus;
using namespace tactus::hal;
using namespace tactus::test;

namespace {

// The arm of a description, each drive in a rack of its own, with one mechanics for all.
struct Apart {
  explicit Apart(const DeviceProfile& profile)
      : drives(profile.description.drives), mechanics(profile, HandModel(), kDrivePeriod_ns) {
    for (unsigned axis = 0; axis < drives.axes.size(); ++axis) {
      racks.emplace_back(drives, kDrivePeriod_ns);
      racks.back().keep_only(axis);
    }
  }
  void hear(unsigned bus, const DriveFrame& frame) {
    for (SimulatedRack& rack : racks) rack.hear(bus, frame, mechanics.shafts());
  }
  void advance() {
    for (SimulatedRack& rack : racks) rack.begin_period();
    mechanics.advance([this](unsigned axis, double speed_rad_per_s, double time_s) {
      const double torque_Nm = racks[axis].drive(axis).law().at(drives.axes[axis], speed_rad_per_s);
      racks[axis].pass(axis, time_s);
      return torque_Nm;
    });
    for (SimulatedRack& rack : racks) rack.end_period(mechanics.shafts());
  }
  // What waits on a bus, of all drives.
  std::vector<DriveFrame> fetch(unsigned bus) {
    std::vector<DriveFrame> frames;
    ReceivedDriveFrame received;
    for (SimulatedRack& rack : racks)
      while (rack.fetch(bus, received)) frames.push_back(received.frame);
    return frames;
  }

  DriveDescription drives;
  ArmMechanics mechanics;
  std::vector<SimulatedRack> racks;
};

// What a host sends in a period: a torque to each drive, enabled before.
std::vector<DriveFrame> commands_of(const DriveDescription& drives, unsigned period) {
  std::vector<DriveFrame> frames;
  for (unsigned i = 0; i < drives.axes.size(); ++i) {
    const DriveCommand command{.action = period == 0 ? DriveAction::kEnable : DriveAction::kTorque,
                               .torque_Nm = 0.02 * (i + 1) * drives.axes[i].torque_range_Nm,
                               .damping_Nms_per_rad = 0.01};
    frames.push_back(codec_of(drives.family).encode(drives.axes[i], command));
  }
  return frames;
}

std::vector<DeviceDescription> all_arms() {
  std::vector<DeviceDescription> arms{wristed_arm_of_moteus()};
  for (unsigned family = 0; family < kDriveFamilies; ++family)
    arms.push_back(point_arm_of(static_cast<DriveFamily>(family)));
  return arms;
}

}  // namespace

TEST_CASE("drives: each by itself on one mechanics moves the arm and answers as the whole arm does, bit by bit") {
  for (const DeviceDescription& description : all_arms()) {
    CAPTURE(description.name, codec_of(description.drives.family).name);
    const DeviceProfile profile = drive_profile(description);
    SimulatedDrives whole(profile, HandModel(), kDrivePeriod_ns);
    Apart apart(profile);
    for (unsigned period = 0; period < 300; ++period) {
      const auto frames = commands_of(description.drives, period);
      for (unsigned i = 0; i < frames.size(); ++i) {
        const unsigned bus = description.drives.axes[i].bus;
        whole.hear(bus, frames[i]);
        apart.hear(bus, frames[i]);
      }
      whole.advance();
      apart.advance();
      for (unsigned bus = 0; bus < whole.buses(); ++bus) {
        std::vector<DriveFrame> told;
        ReceivedDriveFrame received;
        while (whole.fetch(bus, received)) told.push_back(received.frame);
        const auto by_id = [](const DriveFrame& a, const DriveFrame& b) { return a.id < b.id; };
        auto told_apart = apart.fetch(bus);
        std::stable_sort(told.begin(), told.end(), by_id);
        std::stable_sort(told_apart.begin(), told_apart.end(), by_id);
        REQUIRE(told == told_apart);
      }
    }
    REQUIRE(whole.plant().coordinates() == apart.mechanics.plant().coordinates());
    CHECK(whole.plant().coordinates() != SimulatedDrives(profile, HandModel(), kDrivePeriod_ns).plant().coordinates());
  }
}

TEST_CASE("drives: a command is meant by one drive, its answer and other drives' frames by none") {
  for (const DeviceDescription& description : all_arms()) {
    const DriveDescription& drives = description.drives;
    CAPTURE(description.name, codec_of(drives.family).name);
    SimulatedRack rack(drives, kDrivePeriod_ns);
    const auto frames = commands_of(drives, 1);
    for (unsigned i = 0; i < frames.size(); ++i)
      for (unsigned k = 0; k < frames.size(); ++k) {
        CHECK(rack.drive(k).is_meant_by(frames[i]) == (i == k));
        DriveFrame answer;
        if (i == k && rack.drive(k).hear(frames[i], {}, answer))
          for (unsigned other = 0; other < frames.size(); ++other) CHECK_FALSE(rack.drive(other).is_meant_by(answer));
      }
  }
}
