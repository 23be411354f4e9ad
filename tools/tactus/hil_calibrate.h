// tactus hil --calibrate: the force gain of a device, with a kitchen scale and a person who reads it.
//
// Thread: main, as long as the person takes; a thread of hil::HeldForce holds the force meanwhile. Units: N, readings
// in g (tools/hil/scale_calibration.h, which computes the gain).
#pragma once

#include <string>

#include "hal/device_class.h"
#include "tools/hil/device_suite.h"

namespace tactus::tools {

struct GainCalibration {
  const hal::DeviceChoice& choice;  // of a class with a force gain
  hil::DeviceUnderTest& under_test;
  std::string out;  // the configuration that gets the gain; empty: it is shown
  bool json{false};
};

// Asks on stderr, reads stdin. Returns the exit status: 0 good; 1 a doubt, nothing is written; 2 the input ended or the
// file cannot be written; 3 the device does not push.
int calibrate_gain(const GainCalibration& calibration);

}  // namespace tactus::tools
