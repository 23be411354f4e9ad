// Stores the device's configuration: the Storage of firmware/board.h over a memory that survives reset.
//
// On mps2-an386 this is plain memory at an address from the linker script; a port to a chip uses its EEPROM or a flash
// page, and, if writing takes longer than a period, copies the block here and writes it in the background. The size is
// cleared before the block is written and set afterwards, so that a reset in between leaves no block instead of half a
// block; the block's CRC detects other damage. Thread: load() [setup], store() the control period's, [rt]. Bound: one
// block of kConfigBlockSize.
#pragma once

#include "firmware/board.h"

namespace tactus::firmware::cortex_m {

struct StorageMemory {
  std::uint32_t volatile size;
  std::uint32_t volatile words[(kConfigBlockSize + 3) / 4];  // little-endian
};

class BoardStorage {
 public:
  explicit BoardStorage(StorageMemory& memory) noexcept : memory_(memory) {}

  // Also 0 if the stored size is invalid.
  std::size_t load(std::span<std::byte> buffer) noexcept {
    const std::size_t size = memory_.size;
    if (size > kConfigBlockSize || size > buffer.size()) return 0;
    for (std::size_t i = 0; i < size; ++i) buffer[i] = static_cast<std::byte>(memory_.words[i / 4] >> (8 * (i % 4)));
    return size;
  }

  bool store(std::span<const std::byte> block) noexcept {
    if (block.size() > kConfigBlockSize) return false;
    memory_.size = 0;
    for (std::size_t i = 0; i < block.size(); i += 4) {
      std::uint32_t word = 0;
      for (std::size_t k = 0; k < 4 && i + k < block.size(); ++k)
        word |= std::to_integer<std::uint32_t>(block[i + k]) << (8 * k);
      memory_.words[i / 4] = word;
    }
    memory_.size = static_cast<std::uint32_t>(block.size());
    return true;
  }

 private:
  StorageMemory& memory_;
};
static_assert(Storage<BoardStorage>);

}  // namespace tactus::firmware::cortex_m
