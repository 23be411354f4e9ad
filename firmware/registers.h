// Every register of the device: number, name, type, unit, range, and who may write it when.
//
// The device's replies, the saved configuration and the table in PROTOCOL.md all follow this table (a test compares it
// with PROTOCOL.md). A row is a family: `count` registers with successive numbers, one per axis, per term, per word.
// Numbers are explicit and never reused; a row may be added, never changed in type, unit or meaning.
// Thread: [any]; constants and pure functions. Bound: a look-up is a binary search among about fifty rows.
#pragma once

#include <bit>
#include <span>

#include "firmware/device_config.h"

namespace tactus::firmware {

enum class RegisterType : std::uint8_t { kU32 = 0, kI32 = 1, kF32 = 2 };
enum class Access : std::uint8_t { kRead = 0, kReadWrite = 1, kCommand = 2 };
// Part of DeviceConfig that contains the field; kNone: computed by the device.
enum class Section : std::uint8_t { kNone = 0, kControl = 1, kEncoders = 2, kThermal = 3, kGravity = 4, kBus = 5 };

struct Register {
  std::uint16_t number;  // of the first of `count`
  std::uint8_t count;
  RegisterType type;
  Access access;
  std::uint8_t states;  // bit s: writing or executing is allowed in State s
  Section section;
  std::uint8_t width;       // bytes of the field: 1 or 4
  std::uint16_t offset;     // of the first field in its section
  std::uint32_t low, high;  // bits of the lowest and highest accepted value, in the register's type
  const char* name;
  const char* unit;  // "" if dimensionless
};

// Register numbers that the code uses by name; the table in registers.cpp describes the registers.
namespace number {
inline constexpr std::uint16_t kProtocol = 0x0000, kRevision = 0x0001, kFirmware = 0x0002, kDeviceClass = 0x0003,
                               kAxisCount = 0x0004, kSerial = 0x0008, kQuantum = 0x0100, kMaxEffort = 0x0110,
                               kMaxSpeed = 0x0120, kMaxForce = 0x0130, kMaxTorque = 0x0131, kPeriod = 0x0132,
                               kFadeFrames = 0x0133, kBrakeFrames = 0x0134, kDirection = 0x0200, kOffset = 0x0210,
                               kIndexDistance = 0x0220, kIndexPosition = 0x0230, kCradlePosition = 0x0240,
                               kIndexAxes = 0x0250, kIndexTolerance = 0x0251, kHomingDemanded = 0x0252,
                               kSpeedCorner = 0x0253, kThermalGain = 0x0300, kThermalTime = 0x0310,
                               kThermalWarning = 0x0320, kThermalLimit = 0x0330, kGravityConstant = 0x0400,
                               kGravityAmplitude = 0x0410, kGravityCombination = 0x0430, kGravityInIdle = 0x0450,
                               kCanNodeId = 0x0500, kState = 0x0600, kFault = 0x0601, kLimits = 0x0602,
                               kMissedCommands = 0x0603, kRefusedFrames = 0x0604, kDecodeError = 0x0605,
                               kHomingState = 0x0606, kHomedAxes = 0x0607, kSelfTestFailed = 0x0608,
                               kSelfTestPasses = 0x0609, kUptime = 0x060a, kSaveState = 0x060b, kFaultTotal = 0x060c,
                               kEncoderErrors = 0x0610, kSpeed = 0x0620, kWindingRise = 0x0630, kEffortShare = 0x0640,
                               kCanTransmitErrors = 0x0650, kCanReceiveErrors = 0x0651, kCanBusOff = 0x0652,
                               kFaultLog = 0x0700, kSave = 0x0800, kFactory = 0x0801, kHome = 0x0802,
                               kSelfTest = 0x0803;
}  // namespace number

inline constexpr unsigned kFaultLogWords = 4;  // per entry
inline constexpr std::size_t kMaxRegisterCount = 64;

std::span<const Register> all_registers() noexcept;

// The row that contains `wanted`, or null.
const Register* find_register(std::uint16_t wanted) noexcept;

// Finite and within [low, high], compared in the register's type.
bool is_in_range(const Register& row, std::uint32_t bits) noexcept;

// The field of register row.number + index. Precondition: the section is not kNone, index < count.
std::uint32_t read_field(const Register& row, unsigned index, const ConfigView& config) noexcept;
void write_field(const Register& row, unsigned index, std::uint32_t bits, DeviceConfig& config) noexcept;

// True if all fields of the row are bitwise equal in both. Precondition: the section is not kNone.
bool has_same_fields(const Register& row, const ConfigView& a, const ConfigView& b) noexcept;

// Hash of a row, except its name and unit, continued from `so_far`: the self-test recomputes it from memory.
constexpr std::uint32_t fingerprint(std::uint32_t so_far, const Register& row) noexcept {
  const std::uint32_t words[] = {row.number + (std::uint32_t{row.count} << 16) + (std::uint32_t{row.states} << 24),
                                 static_cast<std::uint32_t>(row.type) + (static_cast<std::uint32_t>(row.access) << 8) +
                                     (static_cast<std::uint32_t>(row.section) << 16) + (std::uint32_t{row.width} << 24),
                                 row.offset, row.low, row.high};
  for (const std::uint32_t word : words) so_far = (std::rotl(so_far, 5) ^ word) * 0x9e3779b1u;
  return so_far;
}

// The hash of the whole table, computed at compile time.
std::uint32_t built_fingerprint() noexcept;

}  // namespace tactus::firmware
