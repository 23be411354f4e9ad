#include "firmware/registers.h"

#include <cstddef>
#include <cstring>

#include "firmware/identity.h"

namespace tactus::firmware {
namespace {

using namespace number;

constexpr std::uint8_t state_bit(State state) noexcept { return static_cast<std::uint8_t>(1u << unsigned(state)); }
constexpr std::uint8_t kNever = 0;
constexpr std::uint8_t kCalm = state_bit(State::kReset) | state_bit(State::kIdle) | state_bit(State::kBrake);
constexpr std::uint8_t kStarted = state_bit(State::kIdle) | state_bit(State::kBrake);
constexpr float kMaxPlausible = 1e6f;  // equal to the limit in controller.cpp

// The place of a value in the configuration.
struct Field {
  Section section;
  std::size_t offset;
  std::uint8_t width;
};

// The accepted range of a value, as the bits of its type.
struct Range {
  RegisterType type;
  std::uint32_t low, high;
};
constexpr Range real(float low, float high) noexcept {
  return {RegisterType::kF32, std::bit_cast<std::uint32_t>(low), std::bit_cast<std::uint32_t>(high)};
}
constexpr Range whole(std::uint32_t low, std::uint32_t high) noexcept { return {RegisterType::kU32, low, high}; }
constexpr Range signed_whole(std::int32_t low, std::int32_t high) noexcept {
  return {RegisterType::kI32, static_cast<std::uint32_t>(low), static_cast<std::uint32_t>(high)};
}

constexpr Register stored(std::uint16_t n, std::uint8_t count, const Field& field, const Range& range, const char* name,
                          const char* unit) noexcept {
  return {.number = n,
          .count = count,
          .type = range.type,
          .access = Access::kReadWrite,
          .states = kCalm,
          .section = field.section,
          .width = field.width,
          .offset = static_cast<std::uint16_t>(field.offset),
          .low = range.low,
          .high = range.high,
          .name = name,
          .unit = unit};
}
constexpr Register shown(std::uint16_t n, std::uint8_t count, RegisterType type, const char* name,
                         const char* unit) noexcept {
  return {.number = n,
          .count = count,
          .type = type,
          .access = Access::kRead,
          .states = kNever,
          .section = Section::kNone,
          .width = 4,
          .offset = 0,
          .low = 0,
          .high = 0,
          .name = name,
          .unit = unit};
}
constexpr Register command(std::uint16_t n, std::uint8_t states, std::uint32_t high, const char* name) noexcept {
  return {.number = n,
          .count = 1,
          .type = RegisterType::kU32,
          .access = Access::kCommand,
          .states = states,
          .section = Section::kNone,
          .width = 4,
          .offset = 0,
          .low = 0,
          .high = high,
          .name = name,
          .unit = ""};
}

constexpr Field control(std::size_t offset, std::uint8_t width = 4) noexcept {
  return {Section::kControl, offset, width};
}
constexpr Field encoders(std::size_t offset) noexcept { return {Section::kEncoders, offset, 4}; }
constexpr Field thermal(std::size_t offset) noexcept { return {Section::kThermal, offset, 4}; }
constexpr Field gravity(std::size_t offset) noexcept { return {Section::kGravity, offset, 4}; }
constexpr Field bus(std::size_t offset) noexcept { return {Section::kBus, offset, 4}; }

constexpr RegisterType U = RegisterType::kU32, F = RegisterType::kF32;
constexpr std::int32_t kLowest = -kMaxCount, kHighest = kMaxCount;

// clang-format off
constexpr Register kRegisters[] = {
    shown(kProtocol, 1, U, "protocol_version", ""),
    shown(kRevision, 1, U, "register_revision", ""),
    shown(kFirmware, 1, U, "firmware_version", ""),
    shown(kDeviceClass, 1, U, "device_class", ""),
    shown(kAxisCount, 1, U, "axis_count", ""),
    shown(kSerial, kSerialWords, U, "serial", ""),

    stored(kQuantum, kAxes, control(offsetof(Config, quantum)), real(1e-9f, 1.0f), "quantum", "m or rad per count"),
    stored(kMaxEffort, kAxes, control(offsetof(Config, max_effort)), real(0, kMaxPlausible), "max_effort", "N or N m"),
    stored(kMaxSpeed, kAxes, control(offsetof(Config, max_speed)), real(1e-6f, kMaxPlausible), "max_speed", "m/s or rad/s"),
    stored(kMaxForce, 1, control(offsetof(Config, max_force_N)), real(0, kMaxPlausible), "max_force", "N"),
    stored(kMaxTorque, 1, control(offsetof(Config, max_torque_Nm)), real(0, kMaxPlausible), "max_torque", "N m"),
    shown(kPeriod, 1, U, "period", "us"),
    stored(kFadeFrames, 1, control(offsetof(Config, fade_frames), 1), whole(1, 254), "fade_frames", "periods"),
    stored(kBrakeFrames, 1, control(offsetof(Config, brake_frames), 1), whole(2, 255), "brake_frames", "periods"),

    stored(kDirection, kAxes, encoders(offsetof(EncoderConfig, direction)), signed_whole(-1, 1), "direction", ""),
    stored(kOffset, kAxes, encoders(offsetof(EncoderConfig, offset)), signed_whole(kLowest, kHighest), "offset", "counts"),
    stored(kIndexDistance, kAxes, encoders(offsetof(EncoderConfig, index_distance)), whole(0, kMaxCount), "index_distance", "counts"),
    stored(kIndexPosition, kAxes, encoders(offsetof(EncoderConfig, index_position)), signed_whole(kLowest, kHighest), "index_position", "counts"),
    stored(kCradlePosition, kAxes, encoders(offsetof(EncoderConfig, cradle_position)), signed_whole(kLowest, kHighest), "cradle_position", "counts"),
    stored(kIndexAxes, 1, encoders(offsetof(EncoderConfig, index_axes)), whole(0, kAllAxes), "index_axes", "bits"),
    stored(kIndexTolerance, 1, encoders(offsetof(EncoderConfig, index_tolerance)), whole(0, kMaxCount), "index_tolerance", "counts"),
    stored(kHomingDemanded, 1, encoders(offsetof(EncoderConfig, homing_demanded)), whole(0, 1), "homing_demanded", ""),
    stored(kSpeedCorner, 1, encoders(offsetof(EncoderConfig, speed_corner_Hz)), real(0, 1e5f), "speed_corner", "Hz"),

    stored(kThermalGain, kAxes, thermal(offsetof(ThermalConfig, gain_K_per_effort2)), real(0, kMaxPlausible), "thermal_gain", "K/N^2 or K/(N m)^2"),
    stored(kThermalTime, kAxes, thermal(offsetof(ThermalConfig, time_constant_s)), real(0, kMaxPlausible), "thermal_time", "s"),
    stored(kThermalWarning, kAxes, thermal(offsetof(ThermalConfig, warning_K)), real(0, 1000), "thermal_warning", "K"),
    stored(kThermalLimit, kAxes, thermal(offsetof(ThermalConfig, limit_K)), real(0, 1000), "thermal_limit", "K"),

    stored(kGravityConstant, kAxes, gravity(offsetof(GravityConfig, constant)), real(-kMaxPlausible, kMaxPlausible), "gravity_constant", "N or N m"),
    stored(kGravityAmplitude, kAxes * kGravityTerms, gravity(offsetof(GravityConfig, amplitude)), real(-kMaxPlausible, kMaxPlausible), "gravity_amplitude", "N or N m"),
    stored(kGravityCombination, kAxes * kGravityTerms, gravity(offsetof(GravityConfig, combination)), whole(0, kMaxCombination), "gravity_combination", "bits"),
    stored(kGravityInIdle, 1, gravity(offsetof(GravityConfig, in_idle)), whole(0, 1), "gravity_in_idle", ""),

    stored(kCanNodeId, 1, bus(offsetof(BusConfig, can_node_id)), whole(1, 127), "can_node_id", ""),

    shown(kState, 1, U, "state", ""),
    shown(kFault, 1, U, "fault", ""),
    shown(kLimits, 1, U, "limits", "bits"),
    shown(kMissedCommands, 1, U, "missed_commands", "periods"),
    shown(kRefusedFrames, 1, U, "refused_frames", "frames"),
    shown(kDecodeError, 1, U, "decode_error", ""),
    shown(kHomingState, 1, U, "homing_state", ""),
    shown(kHomedAxes, 1, U, "homed_axes", "bits"),
    shown(kSelfTestFailed, 1, U, "self_test_failed", "bits"),
    shown(kSelfTestPasses, 1, U, "self_test_passes", ""),
    shown(kUptime, 1, U, "uptime", "s"),
    shown(kSaveState, 1, U, "save_state", ""),
    shown(kFaultTotal, 1, U, "fault_total", ""),
    shown(kEncoderErrors, kAxes, U, "encoder_errors", "periods"),
    shown(kSpeed, kAxes, F, "speed", "m/s or rad/s"),
    shown(kWindingRise, kAxes, F, "winding_rise", "K"),
    shown(kEffortShare, kAxes, F, "effort_share", ""),
    shown(kCanTransmitErrors, 1, U, "can_transmit_errors", ""),
    shown(kCanReceiveErrors, 1, U, "can_receive_errors", ""),
    shown(kCanBusOff, 1, U, "can_bus_off", ""),
    shown(kFaultLog, 64, U, "fault_log", ""),

    command(kSave, kCalm, 0, "save"),
    command(kFactory, kCalm, 0, "factory"),
    command(kHome, kStarted, 2, "home"),
    command(kSelfTest, kStarted, 0, "self_test"),
};
// clang-format on

constexpr bool is_sorted_without_overlap() noexcept {
  for (std::size_t i = 1; i < std::size(kRegisters); ++i)
    if (kRegisters[i - 1].number + kRegisters[i - 1].count > kRegisters[i].number) return false;
  return true;
}
static_assert(is_sorted_without_overlap());

constexpr bool single_bytes_stand_alone() noexcept {
  for (const Register& row : kRegisters)
    if (row.width == 1 && row.count != 1) return false;
  return true;
}
static_assert(single_bytes_stand_alone(), "has_same_fields looks at one byte");

constexpr std::uint32_t whole_fingerprint() noexcept {
  std::uint32_t so_far = 0;
  for (const Register& row : kRegisters) so_far = fingerprint(so_far, row);
  return so_far;
}
constexpr std::uint32_t kFingerprint = whole_fingerprint();

const void* section_of(const ConfigView& config, Section section) noexcept {
  switch (section) {
    case Section::kControl:
      return config.control;
    case Section::kEncoders:
      return config.encoders;
    case Section::kThermal:
      return config.thermal;
    case Section::kGravity:
      return config.gravity;
    case Section::kBus:
      return config.bus;
    case Section::kNone:
      break;
  }
  return nullptr;
}

}  // namespace

std::span<const Register> all_registers() noexcept { return kRegisters; }
std::uint32_t built_fingerprint() noexcept { return kFingerprint; }

const Register* find_register(std::uint16_t wanted) noexcept {
  std::size_t first = 0, last = std::size(kRegisters);
  while (first < last) {
    const std::size_t middle = (first + last) / 2;
    const Register& row = kRegisters[middle];
    if (wanted < row.number)
      last = middle;
    else if (wanted >= row.number + row.count)
      first = middle + 1;
    else
      return &row;
  }
  return nullptr;
}

bool is_in_range(const Register& row, std::uint32_t value) noexcept {
  switch (row.type) {
    case RegisterType::kU32:
      return value >= row.low && value <= row.high;
    case RegisterType::kI32: {
      const auto x = static_cast<std::int32_t>(value);
      return x >= static_cast<std::int32_t>(row.low) && x <= static_cast<std::int32_t>(row.high);
    }
    case RegisterType::kF32: {  // NaN compares false
      const auto x = std::bit_cast<float>(value);
      return x >= std::bit_cast<float>(row.low) && x <= std::bit_cast<float>(row.high);
    }
  }
  return false;
}

std::uint32_t read_field(const Register& row, unsigned index, const ConfigView& config) noexcept {
  const auto* at = static_cast<const std::byte*>(section_of(config, row.section)) + row.offset;
  if (row.width == 1) return std::to_integer<std::uint32_t>(at[index]);
  std::uint32_t value;
  std::memcpy(&value, at + 4 * index, 4);
  return value;
}

bool has_same_fields(const Register& row, const ConfigView& a, const ConfigView& b) noexcept {
  const auto* in_a = static_cast<const std::byte*>(section_of(a, row.section)) + row.offset;
  const auto* in_b = static_cast<const std::byte*>(section_of(b, row.section)) + row.offset;
  if (row.width == 1) return *in_a == *in_b;
  std::uint32_t differ = 0;
  for (unsigned i = 0; i < row.count; ++i) {
    std::uint32_t x, y;
    std::memcpy(&x, in_a + 4 * i, 4);
    std::memcpy(&y, in_b + 4 * i, 4);
    differ |= x ^ y;
  }
  return differ == 0;
}

void write_field(const Register& row, unsigned index, std::uint32_t value, DeviceConfig& config) noexcept {
  // The const_cast is valid: the view points into `config`, which is not const.
  auto* at = static_cast<std::byte*>(const_cast<void*>(section_of(config.view(), row.section))) + row.offset;
  if (row.width == 1)
    at[index] = static_cast<std::byte>(value);
  else
    std::memcpy(at + 4 * index, &value, 4);
}

}  // namespace tactus::firmware
