// Stability test: the simulated device is pressed against a wall through the coupling and tapped; stable if the
// oscillation decays.
//
// Device, firmware, encoder, transport delay and mechanics are hal::SimulatedDevice's, the coupling is the haptic
// sub-world's with a proxy before a fixed wall, the velocity the loop's estimate. Parts that could hide an instability
// are left out: passivity controller, limits, the hand's own damping, the device's dry friction. Virtual time: the
// device runs in parts of a haptic tick, so that delay and jitter may be fractions of a tick. Thread: one.
// Units: SI. Same arguments, same bits.
#pragma once

#include "hal/profiles.h"

namespace tactus::experiment {

// Timing of the loop, and its encoder.
struct LoopTiming {
  double rate_Hz{1000};
  double delay_ticks{1};   // transport, beyond the sample-and-hold
  double jitter_ticks{0};  // each tick is late by up to this, uniformly distributed
  double quantum_m{0};     // of the encoder; 0: negligibly small
};

// Number of parts per tick; a part is at least 50 us, the shortest period of the device.
unsigned parts_of_tick(double rate_Hz);

// Properties of the described device in this loop: apparent mass and damping at the tool, on a frictionless stage, with
// delay_s and the quantum of `timing`.
haptics::DeviceProperties device_in(const hal::DeviceDescription& description, const LoopTiming& timing);

// True if the oscillation after the tap has decayed, contact with the wall was never lost, and the oscillation is
// smaller half a second later. Delays and jitter count in whole parts of a tick; at least one part of delay, at most
// 32.
bool rings_out(const hal::DeviceDescription& description, const LoopTiming& timing, double stiffness_N_per_m,
               double damping_Ns_per_m);

// Stability limit of the stiffness, by bisection of the logarithm between `least` and `most` until their ratio is
// `apart` (1.02: 2 %). 0: `least` is already unstable.
double measured_limit(const hal::DeviceDescription& description, const LoopTiming& timing, double damping_Ns_per_m,
                      double least, double most, double apart);

}  // namespace tactus::experiment
