// Writes a description file of a device from few figures: the user gives those that only the builder has, the others
// are estimates that the file marks.
//
// Thread: normal. Units in the names. The text is what hal/device_file.h reads; parse it to check it.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "hal/device_description.h"
#include "hal/profiles.h"
#include "rt/base/result.h"

namespace tactus::device {

// A figure of 0, damping of -1 and an empty text stand for the usual value of the family and the kind, which complete()
// sets.
struct NewDescription {
  std::string name{"my_arm"};
  std::string kind{"point_arm"};  // wristed_arm, point_arm, stage
  std::string family{"damiao"};   // a family of drives, or firmware: tactus' own wire
  std::string buses;              // comma between them
  unsigned rate_Hz{0};            // of the loop: for the load of the buses, and the gains of the scene
  double upper_arm_m{0.3}, forearm_m{0.3};
  double radius_m{0.15};
  double peak_force_N{8}, peak_torque_Nm{0.5};
  double mass_kg{0.4}, inertia_kg_m2{1e-3};
  double damping_Ns_per_m{0.5};
  double coulomb_friction_N{0.3};
  double ratio{0};                 // of the capstans or belts of the first three axes, of drives
  double wrist_ratio{1};           // of the last three
  double drive_damping{-1};        // closed in the drives of the first three axes, N m s/rad
  double wrist_drive_damping{-1};  // and of the last three
  double torque_range_Nm{0};
  double position_range_rad{0}, speed_range_rad_per_s{0};
  double counts_per_turn{0};
  double watchdog_ms{10};
};

// A figure that the user gives: its option, the question, and where it goes.
struct Question {
  const char* option;  // "--radius"
  const char* text;
  const char* unit;
  double NewDescription::*value;
  // True for the descriptions that have the figure.
  bool (*applies)(const NewDescription& description);
};
std::span<const Question> questions() noexcept;

// Error: an unknown kind or family, invalid buses or an invalid name, with what is accepted.
Status check_kind(const NewDescription& description);
Status check_family(const NewDescription& description);
Status check_buses(const NewDescription& description);
Status check_choices(const NewDescription& description);  // all of these, and the name

// Are there drives, with buses to name?
bool has_drives(const NewDescription& description);

// Sets what was not given to the usual value of the family and the kind. With the defaults of this struct every pair of
// family and kind makes a description that is accepted. Precondition: check_choices() is good.
void complete(NewDescription& description);

// The file. Precondition: check_choices() is good, complete() was called.
std::string description_text(const NewDescription& description);

// What follows from a description, a line each: efforts and quanta of the axes, load of the buses.
std::vector<std::string> consequences(const hal::DeviceDescription& description, unsigned rate_Hz);

// A scene to try the device in: a floor and a box, gains that the device bears at this rate, and a hand that presses
// and slides within its workspace.
std::string scene_text(const hal::DeviceProfile& profile, unsigned rate_Hz);

}  // namespace tactus::device
