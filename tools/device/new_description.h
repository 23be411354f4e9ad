// Writes a description file of a device from few figures: those that only its builder knows are asked for, the others
// are estimates that the file marks.
//
// Thread: normal. Units in the names. The text is what hal/device_file.h reads; parse it to check it.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "hal/device_description.h"
#include "rt/base/result.h"

namespace tactus::device {

struct NewDescription {
  std::string name{"my_arm"};
  std::string kind{"point_arm"};  // wristed_arm, point_arm, stage
  std::string family{"damiao"};   // a family of drives, or firmware: tactus' own wire
  std::string buses{"can0"};      // comma between them
  double upper_arm_m{0.3}, forearm_m{0.3};
  double radius_m{0.15};
  double peak_force_N{8}, peak_torque_Nm{0.5};
  double mass_kg{0.4}, inertia_kg_m2{1e-3};
  double damping_Ns_per_m{0.5};
  double coulomb_friction_N{0.3};
  double ratio{1};            // of the capstans, of drives
  double torque_range_Nm{0};  // 0: the family's usual one; also the three below
  double position_range_rad{0}, speed_range_rad_per_s{0};
  double counts_per_turn{0};
  double watchdog_ms{10};
};

// A figure that is asked for: its option, the question, and where it goes.
struct Question {
  const char* option;  // "--radius"
  const char* text;
  const char* unit;
  double NewDescription::*value;
  // Which descriptions have it.
  bool (*applies)(const NewDescription& description);
};
std::span<const Question> questions() noexcept;

// Error: an unknown kind or family, with what is accepted.
Status check_choices(const NewDescription& description);

// Puts the family's usual ranges where none was given.
void complete(NewDescription& description);

// The file. Precondition: check_choices() is good, complete() was called.
std::string description_text(const NewDescription& description);

// What follows from a description, a line each: efforts and quanta of the axes, load of the buses.
std::vector<std::string> consequences(const hal::DeviceDescription& description, unsigned rate_Hz);

}  // namespace tactus::device
