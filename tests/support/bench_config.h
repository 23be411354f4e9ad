// The device of the firmware's tests and of the conformance vectors.
#pragma once

#include "firmware/device.h"

namespace tactus::firmware {

inline DeviceConfig bench_config() {
  DeviceConfig c;
  c.control.quantum = {1e-5f, 1e-5f, 1e-5f, 1e-4f, 1e-4f, 1e-4f};
  c.control.max_effort = {10, 10, 10, 1, 1, 1};
  c.control.max_speed = {2, 2, 2, 20, 20, 20};
  c.control.max_force_N = 12;
  c.control.max_torque_Nm = 1.2f;
  return c;
}

}  // namespace tactus::firmware
