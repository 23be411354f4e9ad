#include "firmware/gravity.h"

#include "firmware/sine.h"

namespace tactus::firmware {
namespace {

float angle_of(std::uint32_t combination, const AxisValues& coordinates) noexcept {
  float angle = 0.0f;
  for (unsigned axis = 0; axis < kAxes; ++axis) {
    const std::int32_t factor = combination_factor(combination, axis);
    if (factor != 0) angle += static_cast<float>(factor) * coordinates[axis];
  }
  return angle;
}

}  // namespace

AxisValues gravity_effort(const GravityConfig& config, const AxisValues& coordinates) noexcept {
  AxisValues effort = config.constant;
  for (unsigned i = 0; i < kAxes; ++i)
    for (unsigned k = 0; k < kGravityTerms; ++k) {
      const unsigned term = kGravityTerms * i + k;
      if (config.amplitude[term] == 0.0f) continue;
      const SineCosine f = sine_cosine(angle_of(config.combination[term], coordinates));
      effort[i] += config.amplitude[term] * ((config.combination[term] & kCosineTerm) != 0 ? f.cosine : f.sine);
    }
  return effort;
}

}  // namespace tactus::firmware
