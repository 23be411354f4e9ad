// The whole configuration of a device: the parts of all modules.
//
// A board supplies it once, at construction (the factory values); registers change it. A module receives its part as a
// whole, between two periods. Units: SI, in each part's names. Thread: [any]; values.
#pragma once

#include "firmware/controller.h"
#include "firmware/gravity.h"
#include "firmware/homing.h"
#include "firmware/thermal.h"

namespace tactus::firmware {

struct BusConfig {
  std::uint32_t can_node_id{1};  // can_codec.h; a new value takes effect when the board restarts
};

// Pointers to the parts of either the active or the accepted configuration: for registers and the self-test.
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

  ConfigView view() const noexcept {
    return {.control = &control, .encoders = &encoders, .thermal = &thermal, .gravity = &gravity, .bus = &bus};
  }
};

// Checks each part for consistency; the registers (registers.h) check the ranges of single values.
inline bool is_valid(const DeviceConfig& config) noexcept {
  return is_valid(config.control) && is_valid(config.encoders) && is_valid(config.thermal);
}

}  // namespace tactus::firmware
