// The simulated device that a hand presses against a wall through the coupling, and a tap: does it ring out?
//
// Device, firmware, encoder, transport delay and mechanics are hal::SimulatedDevice's, the coupling is the haptic
// sub-world's with a proxy before a fixed wall, the velocity the loop's estimate. Left out is what would hide an
// instability: passivity controller, limits, the hand's own damping, the device's dry friction. Virtual time: the
// device runs in parts of a haptic tick, so that delay and lateness of a tick may be parts of it too. Thread: one.
// Units: SI. Same arguments, same bits.
#pragma once

#include "hal/profiles.h"

namespace tactus::experiment {

// How the loop runs, and on what encoder.
struct LoopTiming {
  double rate_Hz{1000};
  double delay_ticks{1};   // transport, beyond the sample-and-hold
  double jitter_ticks{0};  // each tick is late by up to this, evenly spread
  double quantum_m{0};     // of the encoder; 0: far below what is felt
};

// The parts of a tick: a device cannot be asked in less than 50 us.
unsigned parts_of_tick(double rate_Hz);

// What the description's device is, in this loop: mass and damping as felt at the tool, on a stage without friction.
// delay_s and the quantum are set.
haptics::DeviceProperties device_in(const hal::DeviceDescription& description, const LoopTiming& timing);

// True where the tap has rung down, never lost the wall, and rings less half a second later. Delays and jitter count in
// whole parts of a tick; at least one part of delay, at most 32.
bool rings_out(const hal::DeviceDescription& description, const LoopTiming& timing, double stiffness_N_per_m,
               double damping_Ns_per_m);

// By halves in the logarithm between `least` and `most`, until they are `apart` (1.02: 2 %); 0: `least` does not ring
// out.
double measured_limit(const hal::DeviceDescription& description, const LoopTiming& timing, double damping_Ns_per_m,
                      double least, double most, double apart);

}  // namespace tactus::experiment
