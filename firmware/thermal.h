// Thermal model of the motor windings, from the applied efforts; reduces the effort limits before they overheat.
//
// Per motor, first order:  d rise/dt = (gain effort^2 - rise) / time_constant,  rise over ambient [K].
// gain = winding resistance x thermal resistance / (effort per ampere)^2, so gain effort^2 is the steady state of a
// constant effort. Integrated implicitly every kThermalPeriods periods with the mean of effort^2 (stable for any time
// constant, and with a step large enough for float resolution):
//   rise += s (gain mean(effort^2) - rise),  s = T / (time_constant + T),  T = kThermalPeriods x period
// A higher sensor value replaces the model's. Above `warning` the motor's limit falls linearly, to 0 at `limit`; at
// `limit` the motors are shorted (fault 8). Both are checked every kThermalPeriods periods.
// The model starts at ambient: after a power cycle it underestimates hot windings, unless there is a sensor.
// Thread: [rt], the control period's. Bound: constant work. limit 0 (the default): the motor has no model.
#pragma once

#include "firmware/controller.h"

namespace tactus::firmware {

inline constexpr std::uint32_t kThermalPeriods = 64;

struct ThermalConfig {
  AxisValues gain_K_per_effort2{};  // K/N^2, K/(N m)^2
  AxisValues time_constant_s{};
  AxisValues warning_K{};
  AxisValues limit_K{};  // 0: no model
  friend constexpr bool operator==(const ThermalConfig&, const ThermalConfig&) noexcept = default;
};

// Per motor: limit 0, or 0 < warning < limit and a time constant.
bool is_valid(const ThermalConfig& config) noexcept;

class ThermalModel {
 public:
  // Keeps the modelled temperature rises.
  void configure(const ThermalConfig& config) noexcept;

  // Once per period, with the efforts that are applied until the next.
  void update(const AxisValues& effort, const AxisValues& measured_rise_K, std::uint32_t period_us) noexcept;

  const ThermalConfig& config() const noexcept { return config_; }
  const AxisValues& rise_K() const noexcept { return rise_K_; }
  const AxisValues& effort_share() const noexcept { return effort_share_; }  // fraction of each motor's limit, 0 to 1
  bool is_warm() const noexcept { return warm_; }                            // some fraction is below 1
  bool is_too_hot() const noexcept { return hot_axis_ < kAxes; }
  unsigned hot_axis() const noexcept { return hot_axis_; }  // the first at its limit; kAxes: none

 private:
  void judge() noexcept;

  ThermalConfig config_;
  AxisValues rise_K_{}, effort_share_{1, 1, 1, 1, 1, 1};
  AxisValues sum_of_squares_{};
  std::uint32_t periods_{0};
  bool warm_{false};
  unsigned hot_axis_{kAxes};
};

}  // namespace tactus::firmware
