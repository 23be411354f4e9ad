// An arm of drives on simulated drives, and the host that speaks to it once a period.
#pragma once

#include "hal/drives/drive_arm.h"
#include "tests/hal/drives/drive_arms.h"

namespace tactus::test {

// Periods in which a moteus goes from stopped to position mode and the effort reaches its limit, with a margin.
inline constexpr unsigned kMoteusStart = 20;

struct DriveBench {
  explicit DriveBench(const hal::DeviceDescription& description, const hal::HandModel& hand = {})
      : profile(drive_profile(description)), device(open_drives(description, hand)) {}

  void tick() {
    device->read(input);
    ++command.sequence;
    device->write(command);
  }
  void ticks(unsigned count) {
    for (unsigned i = 0; i < count; ++i) tick();
  }
  void want(haptics::DeviceState wanted, unsigned count = 6) {
    command.wanted = wanted;
    ticks(count);
  }
  void rearm() {
    command.wanted = haptics::DeviceState::kForce;
    command.rearm = 1;
    ticks(2);
    command.rearm = 0;
    ticks(6);
  }
  // Injects a fault for `count` periods from the next tick; it acts on that tick's write().
  void inject(hal::DriveFaultKind kind, unsigned axis = 1, std::uint64_t count = 1) {
    device->world().inject({kind, axis, device->world().tick() + 1, count});
  }
  bool any_enabled() {
    for (unsigned i = 0; i < profile.description.drives.axes.size(); ++i)
      if (device->world().drive(i).enabled()) return true;
    return false;
  }
  double force_N() const { return norm(device->world().commanded_wrench().force); }

  hal::DeviceProfile profile;
  std::unique_ptr<hal::SimulatedDriveArm> device;
  haptics::DeviceInput input;
  haptics::DeviceCommand command;
};

// A hand that holds the tool at `place`.
inline hal::HandModel held_at(const Vec3d& place) {
  hal::HandParameters parameters;
  parameters.stiffness_N_per_m = 4000;
  parameters.damping_Ns_per_m = 60;
  const std::vector<hal::HandWaypoint> path = {{0.0, place, {}}, {1.0, place, {}}};
  return hal::HandModel(parameters, path);
}

}  // namespace tactus::test
