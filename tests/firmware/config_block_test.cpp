#include "firmware/config_block.h"

#include <random>
#include <vector>

#include "firmware/little_endian.h"
#include "tests/firmware/device_bench.h"

using namespace tactus::firmware;

namespace {

std::vector<std::byte> block_of(const DeviceConfig& config) {
  ConfigWriter writer;
  writer.begin();
  while (!writer.advance(config.view())) {}
  return {writer.block().begin(), writer.block().end()};
}

void seal(std::vector<std::byte>& block) {
  const std::size_t end = block.size() - 4;
  put<std::uint32_t>(block, end, crc32c(std::span(block).first(end)));
}

void append(std::vector<std::byte>& block, unsigned number, std::uint32_t value) {
  block.resize(block.size() + kConfigEntrySize);
  const std::size_t at = block.size() - 4 - kConfigEntrySize;
  put<std::uint16_t>(block, at, static_cast<std::uint16_t>(number));
  put<std::uint32_t>(block, at + 2, value);
  put<std::uint16_t>(block, 6, static_cast<std::uint16_t>(get<std::uint16_t>(block, 6) + 1));
  seal(block);
}

}  // namespace

TEST_CASE("every register that is written is in the block, once, and the block has room for them") {
  const auto block = block_of(bench_config());
  unsigned kept = 0;
  for (const Register& row : all_registers()) kept += row.access == Access::kReadWrite ? row.count : 0u;
  CHECK(get<std::uint16_t>(block, 6) == kept);
  CHECK(block.size() == kConfigBlockHead + kept * kConfigEntrySize + 4);
  CHECK(kept <= kMaxConfigEntries);
}

TEST_CASE("a block returns each value that was written into it") {
  DeviceConfig config = bench_config();
  config.control.fade_frames = 4;
  config.encoders.offset[3] = -123456;
  config.thermal.time_constant_s[2] = 33;
  config.gravity.combination[23] = kMaxCombination;
  config.bus.can_node_id = 77;
  DeviceConfig read = bench_config();
  REQUIRE(read_config_block(block_of(config), read));
  for (const Register& row : all_registers())
    for (unsigned i = 0; row.section != Section::kNone && i < row.count; ++i)
      REQUIRE(read_field(row, i, read.view()) == read_field(row, i, config.view()));
}

TEST_CASE("a block of another length than its header's is refused") {
  for (const int change : {-1, 1, 6}) {
    auto block = block_of(bench_config());
    block.resize(block.size() + static_cast<std::size_t>(change));
    DeviceConfig read = bench_config();
    CHECK_FALSE(read_config_block(block, read));
  }
}

TEST_CASE("numbers that are unknown, or that no host writes, are skipped") {
  auto block = block_of(bench_config());
  append(block, 0x7abc, 1);
  append(block, number::kState, 1);
  append(block, number::kSave, 1);
  DeviceConfig read = bench_config();
  CHECK(read_config_block(block, read));
}

TEST_CASE("with a value out of range, or values that contradict each other, the whole block is refused") {
  for (const auto& [wanted, value] : {std::pair<unsigned, std::uint32_t>{number::kFadeFrames, 0},
                                      {number::kFadeFrames, 200},
                                      {number::kMaxForce, 0x7fc00000u},
                                      {number::kDirection, 0},
                                      {number::kCanNodeId, 200}}) {
    DeviceConfig config = bench_config();
    config.control.max_force_N = 5;
    auto block = block_of(config);
    append(block, wanted, value);
    DeviceConfig read = bench_config();
    CHECK_FALSE(read_config_block(block, read));
    CHECK(read.control.max_force_N == 12.0f);
  }
}

TEST_CASE("blocks of any length and content are refused or read, and never overrun") {
  std::mt19937_64 random(1);
  const auto good = block_of(bench_config());
  for (int i = 0; i < 5000; ++i) {
    std::vector<std::byte> block(good.begin(),
                                 good.begin() + static_cast<std::ptrdiff_t>(random() % (good.size() + 1)));
    if (random() % 2 == 0 && block.size() > 8) block[random() % 8] = static_cast<std::byte>(random());
    if (block.size() >= 12) seal(block);
    DeviceConfig read = bench_config();
    if (read_config_block(block, read)) REQUIRE(is_valid(read));
  }
}
