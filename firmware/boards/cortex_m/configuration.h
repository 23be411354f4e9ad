// The device that the image is for, until its registers say otherwise: a desktop arm with three force axes.
//
// Units: see controller.h. 1 kHz. The figures are those of the host's profile desk3d, with the margins that it gives to
// a firmware; for another arm change them here, or write the registers.
#pragma once

#include "firmware/controller.h"
#include "firmware/identity.h"

namespace tactus::firmware::cortex_m {

constexpr Config make_configuration() noexcept {
  Config c;
  c.quantum = {2e-5f, 2e-5f, 2e-5f, 1e-4f, 1e-4f, 1e-4f};
  c.max_effort = {8.0f, 8.0f, 8.0f, 0.0f, 0.0f, 0.0f};
  c.max_speed = {1.5f, 1.5f, 1.5f, 15.0f, 15.0f, 15.0f};
  c.max_force_N = 8.0f;
  c.max_torque_Nm = 0.0f;
  c.period_us = 1000;
  return c;
}

// N or N m per motor at the full set-point: what its amplifier gives at its full current.
inline constexpr AxisValues kFullEffort{10.0f, 10.0f, 10.0f, 0.0f, 0.0f, 0.0f};

// A chip has a number of its own to read the serial from.
inline constexpr Identity kIdentity = make_identity(DeviceClass::kDesk3, "mps2-an386");

inline constexpr std::uint32_t kSerialBitRate_Hz = 1'000'000;
// A program that hangs this long loses the motors (NMI), and twice as long its life (reset).
inline constexpr std::uint32_t kWatchdogTimeout_us = 10'000;

}  // namespace tactus::firmware::cortex_m
