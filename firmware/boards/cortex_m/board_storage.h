// Where the board keeps the device's configuration: the Storage of firmware/board.h over a memory that survives reset.
//
// On mps2-an386 that memory is plain, at an address that the linker script gives; a port to a chip puts its EEPROM or
// flash page there, and where writing takes longer than a period it copies the block here and writes beside. The size
// is cleared before the block is written, and set after it: a reset in between leaves nothing rather than a half, and
// the block's own CRC guards what is left. Thread: load() [setup], store() the control period's, [rt]. Bound: one block
// of kConfigBlockSize.
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

  // 0 as well where the memory holds what this class did not write.
  std::size_t load(std::span<std::byte> room) noexcept {
    const std::size_t size = memory_.size;
    if (size > kConfigBlockSize || size > room.size()) return 0;
    for (std::size_t i = 0; i < size; ++i) room[i] = static_cast<std::byte>(memory_.words[i / 4] >> (8 * (i % 4)));
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
