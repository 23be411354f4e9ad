// Reads the text file that describes the mechanics of a Linux board: kernel paths of each axis's counter and PWM, the
// lines, and the controller's initial limits.
//
// Lines of `key = value`; # begins a comment; each key at most once. Axes 0 to 2 are prismatic (m, N), 3 to 5 rotary
// (rad, N m); an omitted part does not exist. An axis without a PWM has no motor, one without a counter does not move.
//   device_class = 1              of identity.h
//   max_force_N = 10              norm of axes 0 to 2         max_torque_Nm = 1      norm of axes 3 to 5
//   pwm_period_ns = 50000         of all motors
//   stop_line = PATH              the e-stop                  stop_line_active = 1   what it reads when it is active
//   motor_bus = PATH              the motors' supply          motor_bus_good = 1     what it reads when it is good
//   brake_line = PATH             shorts the motors           brake_line_active = 1  what is written to short them
//   axis0.count = /sys/bus/counter/devices/counter0/count0/count
//   axis0.count_bits = 32         width of that counter, 8 to 64
//   axis0.quantum = 1e-5          m or rad per count          axis0.max_speed = 1    m/s or rad/s
//   axis0.pwm = /sys/class/pwm/pwmchip0/pwm0                  exported
//   axis0.full_effort = 6         N or N m at full duty       axis0.max_effort = 5   N or N m
//   axis0.direction = PATH        gets 0 for a positive effort, 1 for a negative one
// Thread: [setup]. Every error is one line with the file, the line, and what is accepted.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "firmware/controller.h"
#include "firmware/identity.h"

namespace tactus::firmware {

struct LineDescription {
  std::string path;  // empty: no such line
  char active{'1'};
};

struct AxisDescription {
  std::string count, pwm, direction;  // paths; empty: none
  unsigned count_bits{32};
  float full_effort{0};
};

struct MechanicsDescription {
  MechanismClass device_class{MechanismClass::kUnknown};
  Config control;  // except its period, which the program sets
  std::array<AxisDescription, kAxes> axes;
  LineDescription stop_line, motor_bus, brake_line;
  std::uint32_t pwm_period_ns{50'000};  // 20 kHz: inaudible
};

// Return the error; empty: none. `name`: the file's name, for the error.
std::string parse_mechanics(std::string_view text, const std::string& name, MechanicsDescription& description);
std::string read_mechanics(const std::string& path, MechanicsDescription& description);

}  // namespace tactus::firmware
