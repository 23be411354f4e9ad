#include "firmware/config_block.h"

#include "firmware/little_endian.h"

namespace tactus::firmware {
namespace {

constexpr std::uint32_t kBlockMagic = 0x47464354u;  // "TCFG"
constexpr std::uint16_t kBlockVersion = 1;
constexpr std::size_t kCrcSize = 4;

bool is_kept(const Register& row) noexcept { return row.access == Access::kReadWrite; }

std::uint16_t entry_count() noexcept {
  unsigned count = 0;
  for (const Register& row : all_registers()) count += is_kept(row) ? row.count : 0u;
  return static_cast<std::uint16_t>(count);
}

}  // namespace

void ConfigWriter::begin() noexcept {
  const std::span<std::byte> out(bytes_);
  put<std::uint32_t>(out, 0, kBlockMagic);
  put<std::uint16_t>(out, 4, kBlockVersion);
  put<std::uint16_t>(out, 6, entry_count());
  size_ = kConfigBlockHead;
  row_ = 0;
  crc_ = crc32c_continued(0, block());
}

bool ConfigWriter::advance(const ConfigView& config) noexcept {
  const std::span<std::byte> out(bytes_);
  const std::span<const Register> rows = all_registers();
  if (row_ == rows.size()) {
    put<std::uint32_t>(out, size_, crc_);
    size_ += kCrcSize;
    return true;
  }
  const Register& row = rows[row_++];
  if (!is_kept(row)) return false;
  const std::size_t from = size_;
  for (unsigned i = 0; i < row.count && size_ + kConfigEntrySize + kCrcSize <= kConfigBlockSize; ++i) {
    put<std::uint16_t>(out, size_, static_cast<std::uint16_t>(row.number + i));
    put<std::uint32_t>(out, size_ + 2, read_field(row, i, config));
    size_ += kConfigEntrySize;
  }
  crc_ = crc32c_continued(crc_, block().subspan(from));
  return false;
}

bool read_config_block(std::span<const std::byte> block, DeviceConfig& config) noexcept {
  if (block.size() < kConfigBlockHead + kCrcSize || get<std::uint32_t>(block, 0) != kBlockMagic) return false;
  if (get<std::uint16_t>(block, 4) != kBlockVersion) return false;
  const std::size_t entries = get<std::uint16_t>(block, 6);
  const std::size_t size = kConfigBlockHead + entries * kConfigEntrySize;
  if (block.size() != size + kCrcSize || get<std::uint32_t>(block, size) != crc32c(block.first(size))) return false;

  DeviceConfig read = config;
  for (std::size_t i = 0; i < entries; ++i) {
    const std::size_t at = kConfigBlockHead + i * kConfigEntrySize;
    const auto wanted = get<std::uint16_t>(block, at);
    const auto value = get<std::uint32_t>(block, at + 2);
    const Register* row = find_register(wanted);
    if (row == nullptr || !is_kept(*row)) continue;
    if (!is_in_range(*row, value)) return false;
    write_field(*row, static_cast<unsigned>(wanted - row->number), value, read);
  }
  if (!is_valid(read)) return false;
  config = read;
  return true;
}

}  // namespace tactus::firmware
