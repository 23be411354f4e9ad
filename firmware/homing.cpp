#include "firmware/homing.h"

namespace tactus::firmware {
namespace {

constexpr std::uint32_t bit(unsigned axis) noexcept { return 1u << axis; }

// Wraps to 32 bits without signed overflow.
constexpr std::int32_t wrapped(std::int64_t x) noexcept {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(static_cast<std::uint64_t>(x)));
}

// The multiple of `distance` nearest to x, halves away from zero.
constexpr std::int64_t nearest_multiple(std::int64_t x, std::int64_t distance) noexcept {
  const std::int64_t half = distance / 2;
  return (x < 0 ? x - half : x + half) / distance * distance;
}

}  // namespace

bool is_valid(const EncoderConfig& config) noexcept {
  bool valid = config.index_axes <= kAllAxes && config.speed_corner_Hz >= 0.0f;
  for (unsigned i = 0; i < kAxes; ++i) {
    valid = valid && (config.direction[i] == 1 || config.direction[i] == -1);
    // A tolerance of half a distance would accept any count.
    const std::uint32_t distance = config.index_distance[i];
    valid = valid && (distance == 0 || (distance <= static_cast<std::uint32_t>(kMaxCount) &&
                                        config.index_tolerance < (distance + 1) / 2));
  }
  return valid;
}

void Encoders::configure(const EncoderConfig& config) noexcept {
  if (config == config_) return;
  config_ = config;
  offset_ = config.offset;
  homing_ = false;
  homed_axes_ = 0;
  referenced_ = 0;
  meaning_changed_ = true;
}

bool Encoders::order(HomingOrder order) noexcept {
  switch (order) {
    case HomingOrder::kForget:
      homing_ = false;
      homed_axes_ = 0;
      referenced_ = 0;
      return true;
    case HomingOrder::kByIndex:
      if (config_.index_axes == 0) return false;
      homing_ = true;
      homed_axes_ = kAllAxes & ~config_.index_axes;
      referenced_ = 0;
      return true;
    case HomingOrder::kInCradle:
      for (unsigned i = 0; i < kAxes; ++i)
        set_offset(i, wrapped(std::int64_t{config_.cradle_position[i]} - std::int64_t{config_.direction[i]} * raw_[i]));
      homing_ = false;
      homed_axes_ = kAllAxes;
      referenced_ = 0;
      return true;
  }
  return false;
}

Encoders::Reading Encoders::update(const ControllerInputs& inputs) noexcept {
  Reading reading;
  reading.fault_axes = static_cast<std::uint8_t>(inputs.encoder_errors & kAllAxes);
  const std::uint32_t edges = inputs.index_edges & config_.index_axes & ~std::uint32_t{reading.fault_axes};
  for (unsigned i = 0; i < kAxes; ++i) {
    if ((edges & bit(i)) == 0) continue;
    if (!index_fits(i, inputs.index_counts[i]))
      reading.fault_axes = static_cast<std::uint8_t>(reading.fault_axes | bit(i));
    else if (homing_ && (homed_axes_ & bit(i)) == 0)
      home_by_index(i, inputs.index_counts[i]);
  }
  for (unsigned i = 0; i < kAxes; ++i) {
    if ((reading.fault_axes & bit(i)) == 0) continue;
    errors_[i] += errors_[i] != 0xffffffffu ? 1u : 0u;
    homed_axes_ &= ~bit(i);
    referenced_ &= ~bit(i);
  }
  if (homing_ && homed_axes_ == kAllAxes) homing_ = false;

  reading.meaning_changed = meaning_changed_;
  meaning_changed_ = false;
  for (unsigned i = 0; i < kAxes; ++i) {
    reading.before[i] = count_of_raw(i, raw_[i]);
    reading.counts[i] = count_of_raw(i, inputs.counts[i]);
  }
  raw_ = inputs.counts;
  return reading;
}

// Compares with the first pulse, not the last, so that a slowly growing error (a count per turn) is detected too.
bool Encoders::index_fits(unsigned axis, std::int32_t latched) noexcept {
  if ((referenced_ & bit(axis)) == 0) {
    reference_[axis] = latched;
    referenced_ |= bit(axis);
    return true;
  }
  std::int64_t off = count_difference(latched, reference_[axis]);
  if (const std::int64_t distance = config_.index_distance[axis]; distance > 0) off -= nearest_multiple(off, distance);
  return (off < 0 ? -off : off) <= std::int64_t{config_.index_tolerance};
}

void Encoders::home_by_index(unsigned axis, std::int32_t latched) noexcept {
  std::int64_t position = config_.index_position[axis];
  if (const std::int64_t distance = config_.index_distance[axis]; distance > 0)
    position += nearest_multiple(count_difference(count_of_raw(axis, latched), wrapped(position)), distance);
  set_offset(axis, wrapped(position - std::int64_t{config_.direction[axis]} * latched));
  homed_axes_ |= bit(axis);
}

void Encoders::set_offset(unsigned axis, std::int32_t offset) noexcept {
  meaning_changed_ = meaning_changed_ || offset_[axis] != offset;
  offset_[axis] = offset;
}

std::int32_t Encoders::count_of_raw(unsigned axis, std::int32_t raw) const noexcept {
  return wrapped(std::int64_t{config_.direction[axis]} * raw + offset_[axis]);
}

}  // namespace tactus::firmware
