// How warm the motors' windings are, from the efforts that they gave; cuts the effort before they burn.
//
// Per motor, first order:  d rise/dt = (gain effort^2 - rise) / time_constant,  rise over ambient [K].
// gain = winding resistance x thermal resistance / (effort per ampere)^2, so gain effort^2 is where a constant effort
// ends. Solved implicitly every kThermalPeriods periods with the mean of effort^2 (stable for any time constant, and
// large enough a step that float does not lose it):
//   rise += s (gain mean(effort^2) - rise),  s = T / (time_constant + T),  T = kThermalPeriods x period
// A sensor's figure counts where it is higher. Above `warning` the motor's limit falls linearly, to 0 at `limit`; at
// `limit` the motors are shorted (fault 8). Both are looked at in every update, so at most kThermalPeriods late.
// The model starts at ambient: a device that was switched off hot is believed cool; the sensor, if any, is not fooled.
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

// Per motor: no limit, or 0 < warning < limit and a time constant.
bool is_valid(const ThermalConfig& config) noexcept;

class ThermalModel {
 public:
  // The rises stay: a configuration cools nothing.
  void configure(const ThermalConfig& config) noexcept;

  // Once per period, with the efforts that act until the next.
  void update(const AxisValues& effort, const AxisValues& measured_rise_K, std::uint32_t period_us) noexcept;

  const ThermalConfig& config() const noexcept { return config_; }
  const AxisValues& rise_K() const noexcept { return rise_K_; }
  const AxisValues& effort_share() const noexcept { return effort_share_; }  // of each motor's limit, 0 to 1
  bool is_warm() const noexcept { return warm_; }                            // some share is below 1
  bool is_too_hot() const noexcept { return hot_axis_ < kAxes; }
  unsigned hot_axis() const noexcept { return hot_axis_; }  // the first at its limit; kAxes: none is

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
