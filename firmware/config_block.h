// The configuration as a block of bytes for non-volatile storage: the command register `save` passes it to the board.
//
// Layout, little-endian: 0 u32 magic "TCFG", 4 u16 block version 1, 6 u16 number of entries, then per entry u16
// register number and u32 value, at the end u32 CRC-32C of all before. Entries are identified by register number, so
// that a block of older or newer firmware can be read as far as both have the registers. Thread: [rt]; the writer adds
// one row of the table per call, to keep periods short; reading is [setup]. Bound: kConfigBlockSize.
#pragma once

#include "firmware/registers.h"

namespace tactus::firmware {

inline constexpr std::size_t kConfigEntrySize = 6, kConfigBlockHead = 8, kMaxConfigEntries = 160;
inline constexpr std::size_t kConfigBlockSize = kConfigBlockHead + kConfigEntrySize * kMaxConfigEntries + 4;

class ConfigWriter {
 public:
  void begin() noexcept;
  // Adds one row; true once the block is complete. `config` must not change from begin() until then.
  bool advance(const ConfigView& config) noexcept;
  // Valid until the next begin().
  std::span<const std::byte> block() const noexcept { return std::span(bytes_).first(size_); }

 private:
  std::array<std::byte, kConfigBlockSize> bytes_{};
  std::size_t size_{0}, row_{0};
  std::uint32_t crc_{0};
};

// Copies the entries into `config`. False, with `config` unchanged: not such a block, corrupt, a value out of its
// register's range, or an inconsistent configuration. Unknown register numbers are ignored.
[[nodiscard]] bool read_config_block(std::span<const std::byte> block, DeviceConfig& config) noexcept;

}  // namespace tactus::firmware
