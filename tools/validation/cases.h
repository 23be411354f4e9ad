// The families of hard cases, one file each; hard_cases() gathers them. Thread: [setup].
#pragma once

#include "tools/validation/hard_case.h"

namespace tactus::hard_cases {

std::vector<HardCase> stack_cases();     // stacks, mass ratios, card houses
std::vector<HardCase> rest_cases();      // what must not move
std::vector<HardCase> friction_cases();  // slopes, spinning, rolling, locking
std::vector<HardCase> motion_cases();    // free bodies, fast spins
std::vector<HardCase> impact_cases();    // fast, deep, sudden
std::vector<HardCase> coupling_cases();  // the device's spring
std::vector<HardCase> border_cases();
std::vector<HardCase> session_cases();  // whole runs in virtual time: device, border, late world
std::vector<HardCase> effect_cases();   // bounces, joints, torsional friction
std::vector<HardCase> device_cases();   // several devices on one world
std::vector<HardCase> hands_cases();    // whole runs of two hands

}  // namespace tactus::hard_cases
