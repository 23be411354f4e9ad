// The whole configuration of a device: each room's own part, side by side.
//
// A board states it once, at construction (the factory's values); registers change it. A part is given to its room
// whole, between two periods. Units: SI, in each part's names. Thread: [any]; values.
#pragma once

#include "firmware/controller.h"
#include "firmware/gravity.h"
#include "firmware/homing.h"
#include "firmware/thermal.h"

namespace tactus::firmware {

struct BusConfig {
  std::uint32_t can_node_id{1};  // can_codec.h; a board listens to a new one when it starts next
};

// The parts, where they are in force or where they wait: what registers read and the self-test compares.
struct ConfigView {
  const Config* control;
  const EncoderConfig* encoders;
  const ThermalConfig* thermal;
  const GravityConfig* gravity;
  const BusConfig* bus;
};

struct DeviceConfig {
  Config control;
  EncoderConfig encoders;
  ThermalConfig thermal;
  GravityConfig gravity;
  BusConfig bus;

  ConfigView view() const noexcept { return {&control, &encoders, &thermal, &gravity, &bus}; }
};

// Every part makes sense; ranges of single values are the registers' (registers.h).
inline bool is_valid(const DeviceConfig& config) noexcept {
  return is_valid(config.control) && is_valid(config.encoders) && is_valid(config.thermal);
}

}  // namespace tactus::firmware
