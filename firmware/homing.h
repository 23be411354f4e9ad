// Converts raw encoder counts to axis positions: direction, offset, homing, index pulses, encoder faults.
//
//   count = direction x raw + offset        (reported in the state frame; the host multiplies by the quantum)
//
// The offset is the configuration's until homing determines it:
//   in the cradle: the device lies in its cradle, so every count is set to the cradle position;
//   by index: the user moves the device, motors free, through the index pulses of all axes in index_axes; each pulse
//     is at index_position + k index_distance, with the k nearest to the count by the present offset.
//     With index_distance 0 there is one pulse in the whole range. Other axes keep their offset (absolute encoders).
// Every later pulse must be a multiple of index_distance from the first, within index_tolerance: otherwise counts were
// lost. After an encoder fault the axis is no longer homed, because its position is unreliable.
// Units: counts. Thread: [rt], the control period's. Bound: constant work; counts wrap at 32 bits.
#pragma once

#include "firmware/controller.h"

namespace tactus::firmware {

struct EncoderConfig {
  std::array<std::int32_t, kAxes> direction{1, 1, 1, 1, 1, 1};  // 1 or -1
  AxisCounts offset{};
  std::array<std::uint32_t, kAxes> index_distance{};  // between two pulses; 0: only one pulse
  AxisCounts index_position{};                        // of one pulse, after direction and offset
  AxisCounts cradle_position{};
  std::uint32_t index_axes{0};  // bit k: axis k has index pulses
  std::uint32_t index_tolerance{0};
  std::uint32_t homing_demanded{0};  // 1: no FORCE before homing
  float speed_corner_Hz{0};          // corner frequency of speed_filter.h; 0: no filter
  friend constexpr bool operator==(const EncoderConfig&, const EncoderConfig&) noexcept = default;
};

bool is_valid(const EncoderConfig& config) noexcept;

// Values of the registers homing_state and home.
enum class HomingState : std::uint32_t { kNotHomed = 0, kHoming = 1, kHomed = 2 };
enum class HomingOrder : std::uint32_t { kForget = 0, kByIndex = 1, kInCradle = 2 };

inline constexpr std::uint32_t kAllAxes = (1u << kAxes) - 1;

class Encoders {
 public:
  struct Reading {
    AxisCounts counts{};
    bool meaning_changed{false};  // direction or offset changed since the last reading
    AxisCounts before{};          // the last reading, with the present direction and offset
    std::uint8_t fault_axes{0};   // bit k: axis k has a fault now
  };

  // A changed configuration resets the homing of all axes.
  void configure(const EncoderConfig& config) noexcept;
  Reading update(const ControllerInputs& inputs) noexcept;
  // False: invalid order, or kByIndex without an axis that has an index.
  [[nodiscard]] bool order(HomingOrder order) noexcept;

  const EncoderConfig& config() const noexcept { return config_; }
  HomingState state() const noexcept {
    return homing_ ? HomingState::kHoming : homed_axes_ == kAllAxes ? HomingState::kHomed : HomingState::kNotHomed;
  }
  std::uint32_t homed_axes() const noexcept { return homed_axes_; }
  std::uint32_t errors(unsigned axis) const noexcept { return errors_[axis]; }  // periods with a fault; saturates

 private:
  bool index_fits(unsigned axis, std::int32_t latched) noexcept;
  void home_by_index(unsigned axis, std::int32_t latched) noexcept;
  void set_offset(unsigned axis, std::int32_t offset) noexcept;
  std::int32_t count_of_raw(unsigned axis, std::int32_t raw) const noexcept;

  EncoderConfig config_;
  AxisCounts offset_{}, raw_{};
  AxisCounts reference_{};       // the first pulse's raw count
  std::uint32_t referenced_{0};  // bit k: axis k has a reference
  std::uint32_t homed_axes_{0};
  bool homing_{false}, meaning_changed_{false};
  std::array<std::uint32_t, kAxes> errors_{};
};

}  // namespace tactus::firmware
