#include "firmware/can_bus_load.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>
#include <vector>

using namespace tactus::firmware;

// A frame bit by bit as it goes out: start, 11 bits of identifier, RTR, IDE, r0, length, data, CRC. The worst data is
// not sought here; the bound must hold for whatever comes.
TEST_CASE("no classic frame is longer than the bound, and the bound is the known one for every length") {
  const std::array<std::uint32_t, 9> known{55, 65, 75, 85, 95, 105, 115, 125, 135};
  for (std::uint32_t n = 0; n <= 8; ++n) CHECK(worst_classic_bits(n) == known[n]);

  std::mt19937_64 random(81);
  std::uint32_t longest = 0;
  for (unsigned round = 0; round < 20000; ++round) {
    std::vector<bool> bits{false};
    const auto put_bits = [&bits](std::uint64_t value, unsigned count) {
      while (count-- > 0) bits.push_back((value >> count & 1u) != 0);
    };
    put_bits(random() % 2 == 0 ? 0x078 : random(), 11);
    put_bits(0, 3);
    put_bits(8, 4);
    put_bits(random() % 2 == 0 ? 0x3c3c3c3c3c3c3c3cull : random(), 64);
    std::uint32_t crc = 0;
    for (const bool bit : bits) {
      const bool feeds = bit != ((crc >> 14 & 1u) != 0);
      crc = (crc << 1 ^ (feeds ? 0x4599u : 0u)) & 0x7fffu;
    }
    put_bits(crc, 15);
    std::uint32_t stuffed = 0;
    unsigned run = 0;
    bool level = true;
    for (const bool bit : bits) {
      run = bit == level ? run + 1 : 1;
      level = bit;
      if (run == 5) {
        ++stuffed;
        level = !level;
        run = 1;
      }
    }
    longest =
        std::max(longest, static_cast<std::uint32_t>(bits.size()) + stuffed + 10 + 3);  // delimiters, ACK, end; gap
  }
  CHECK(longest <= worst_classic_bits(8));
  CHECK(longest >= worst_classic_bits(8) - 8);
}

TEST_CASE("the stated rates follow from the load of a period") {
  // Classic at 1 Mbit/s: 5.1 frames of 135 us.
  CHECK(worst_period_ns(1'000'000, 0) == 688'500);
  CHECK(worst_period_ns(1'000'000, 0) + 2 * 135'000 < 1'000'000);
  // FD: 33 slow bits; state 5 + 512 + 129 + 32 + 1, command 5 + 384 + 97 + 32 + 1 fast ones.
  CHECK(worst_fd_ns(64, 1'000'000, 5'000'000) == 33'000 + 679 * 200);
  CHECK(worst_fd_ns(48, 1'000'000, 5'000'000) == 33'000 + 519 * 200);
  CHECK(worst_period_ns(1'000'000, 2'000'000) == 66'000 + (679 + 519) * 500);
}
