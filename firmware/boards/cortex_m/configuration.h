// The factory configuration of the image: a desktop arm with three force axes. Registers can change it.
//
// Thread: [any]; constants. Units: see controller.h; the three axes are rotary, rad and N m. 1 kHz. The figures are
// those that the host computes from its description desk3d, to four digits (a test compares the two); for another arm
// change them here, or write the registers.
#pragma once

#include "firmware/controller.h"
#include "firmware/identity.h"

namespace tactus::firmware::cortex_m {

constexpr Config make_configuration() noexcept {
  Config c;
  c.quantum = {1.25663704e-4f, 1.25663704e-4f, 1.25663704e-4f, 1e-4f, 1e-4f, 1e-4f};  // 50 000 counts a turn
  c.max_effort = {2.085f, 1.396f, 1.396f, 0.0f, 0.0f, 0.0f};
  c.max_speed = {25.74f, 23.07f, 23.07f, 1.0f, 1.0f, 1.0f};
  c.max_force_N = 2.085f;  // norm of the three axes, N m since they are rotary
  c.max_torque_Nm = 0.0f;
  c.period_us = 1000;
  return c;
}

// N m per motor at the full set-point, which is the amplifier's full current.
inline constexpr AxisValues kFullEffort{2.5f, 2.5f, 2.5f, 0.0f, 0.0f, 0.0f};

// On a chip, read the serial number from its unique ID instead.
inline constexpr Identity kIdentity = make_identity(MechanismClass::kDesk3, "mps2-an386");

inline constexpr std::uint32_t kSerialBitRate_Hz = 1'000'000;
// If the program hangs this long, the NMI shorts the motors; after twice this time the chip is reset.
inline constexpr std::uint32_t kWatchdogTimeout_us = 10'000;

}  // namespace tactus::firmware::cortex_m
