#include "firmware/thermal.h"

namespace tactus::firmware {
namespace {

// The highest limit that a register accepts. Sensor values are clamped to it: from infinity the model would not
// recover.
constexpr float kHottest_K = 1000.0f;

}  // namespace

bool is_valid(const ThermalConfig& config) noexcept {
  bool valid = true;
  for (unsigned i = 0; i < kAxes; ++i) {
    const bool off = config.limit_K[i] == 0.0f;
    valid = valid && (off || (config.warning_K[i] > 0.0f && config.warning_K[i] < config.limit_K[i] &&
                              config.time_constant_s[i] > 0.0f));
  }
  return valid;
}

void ThermalModel::configure(const ThermalConfig& config) noexcept {
  config_ = config;
  judge();
}

void ThermalModel::update(const AxisValues& effort, const AxisValues& measured_rise_K,
                          std::uint32_t period_us) noexcept {
  for (unsigned i = 0; i < kAxes; ++i) sum_of_squares_[i] += effort[i] * effort[i];
  if (++periods_ < kThermalPeriods) return;

  const float step_s = static_cast<float>(kThermalPeriods) * 1e-6f * static_cast<float>(period_us);
  for (unsigned i = 0; i < kAxes; ++i) {
    const float mean_square = sum_of_squares_[i] * (1.0f / static_cast<float>(kThermalPeriods));
    sum_of_squares_[i] = 0.0f;
    if (config_.limit_K[i] == 0.0f) continue;
    const float share = step_s / (config_.time_constant_s[i] + step_s);
    rise_K_[i] += share * (config_.gain_K_per_effort2[i] * mean_square - rise_K_[i]);
    const float measured_K = measured_rise_K[i] < kHottest_K ? measured_rise_K[i] : kHottest_K;
    if (measured_rise_K[i] > rise_K_[i]) rise_K_[i] = measured_K;  // false for NaN
  }
  periods_ = 0;
  judge();
}

void ThermalModel::judge() noexcept {
  warm_ = false;
  hot_axis_ = kAxes;
  for (unsigned i = kAxes; i-- > 0;) {
    effort_share_[i] = 1.0f;
    const float limit = config_.limit_K[i], warning = config_.warning_K[i];
    if (limit == 0.0f || rise_K_[i] <= warning) continue;
    const float share = (limit - rise_K_[i]) / (limit - warning);
    effort_share_[i] = share > 0.0f ? share : 0.0f;
    warm_ = true;
    if (!(rise_K_[i] < limit)) hot_axis_ = i;
  }
}

}  // namespace tactus::firmware
