// The configuration as bytes that survive the supply: what the command register `save` hands to the board.
//
// Layout, little-endian: 0 u32 magic "TCFG", 4 u16 block version 1, 6 u16 number of entries, then per entry u16
// register number and u32 value, at the end u32 CRC-32C of all before. Entries by number, so that a block of an older
// or newer device is understood as far as both know the registers. Thread: [rt]; a writer does one row of the table per
// call, so that no period is long; reading is [setup]. Bound: kConfigBlockSize.
#pragma once

#include "firmware/registers.h"

namespace tactus::firmware {

inline constexpr std::size_t kConfigEntrySize = 6, kConfigBlockHead = 8, kMaxConfigEntries = 160;
inline constexpr std::size_t kConfigBlockSize = kConfigBlockHead + kConfigEntrySize * kMaxConfigEntries + 4;

class ConfigWriter {
 public:
  void begin() noexcept;
  // One row; true once the block is whole. `config` may not change from begin() until then.
  bool advance(const ConfigView& config) noexcept;
  // Valid until the next begin().
  std::span<const std::byte> block() const noexcept { return std::span(bytes_).first(size_); }

 private:
  std::array<std::byte, kConfigBlockSize> bytes_{};
  std::size_t size_{0}, row_{0};
  std::uint32_t crc_{0};
};

// Takes the entries over into `config`. False, and `config` as it was: not such a block, broken, a value out of its
// register's range, or a whole that makes no sense. Numbers that are not known are passed over.
[[nodiscard]] bool read_config_block(std::span<const std::byte> block, DeviceConfig& config) noexcept;

}  // namespace tactus::firmware
