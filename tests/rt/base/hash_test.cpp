#include "rt/base/hash.h"

#include <array>
#include <catch2/catch.hpp>
#include <random>
#include <vector>

#include "rt/base/crc32.h"

using namespace tactus;

namespace {

std::uint64_t fnv_of(std::string_view text) {
  Fnv1a hash;
  hash.add_text(text);
  return hash.value();
}

}  // namespace

TEST_CASE("FNV-1a gives the values that its authors published", "[base]") {
  CHECK(fnv_of("") == 0xcbf29ce484222325ull);
  CHECK(fnv_of("a") == 0xaf63dc4c8601ec8cull);
  CHECK(fnv_of("foobar") == 0x85944171f73967e8ull);
}

TEST_CASE("the hash of values is the hash of their bytes, in the order in which they were added", "[base]") {
  const double x = 0.1;
  const std::uint32_t n = 0x01020304;
  Fnv1a by_value, by_bytes, reversed;
  by_value.add(x);
  by_value.add(n);
  by_bytes.add_bytes(std::as_bytes(std::span(&x, 1)));
  by_bytes.add_bytes(std::as_bytes(std::span(&n, 1)));
  reversed.add(n);
  reversed.add(x);
  CHECK(by_value.value() == by_bytes.value());
  CHECK(by_value.value() != reversed.value());
}

TEST_CASE("minus zero and zero have different hashes: bits are compared, not numbers", "[base]") {
  Fnv1a a, b;
  a.add(0.0);
  b.add(-0.0);
  CHECK(a.value() != b.value());
}

TEST_CASE("the checksum of the nine digits is the one that the standard gives", "[base]") {
  constexpr std::string_view digits = "123456789";
  Crc32 crc;
  crc.add_bytes(std::as_bytes(std::span(digits.data(), digits.size())));
  CHECK(crc.value() == 0xcbf43926u);
  CHECK(Crc32().value() == 0u);
}

TEST_CASE("the checksum detects every burst of up to 32 bits, and does not depend on the pieces", "[base]") {
  std::mt19937 random(1);
  std::vector<std::byte> bytes(64);
  for (auto& b : bytes) b = static_cast<std::byte>(random());
  Crc32 whole;
  whole.add_bytes(bytes);
  for (int round = 0; round < 1000; ++round) {
    const std::size_t cut = random() % bytes.size();
    Crc32 pieces;
    pieces.add_bytes(std::span(bytes).first(cut));
    pieces.add_bytes(std::span(bytes).subspan(cut));
    REQUIRE(pieces.value() == whole.value());

    auto damaged = bytes;
    const std::size_t first_bit = random() % (bytes.size() * 8 - 32);
    const std::uint32_t burst = static_cast<std::uint32_t>(random()) | 1u;
    for (std::size_t i = 0; i < 32; ++i) {
      if ((burst >> i & 1u) != 0) damaged[(first_bit + i) / 8] ^= static_cast<std::byte>(1u << (first_bit + i) % 8);
    }
    Crc32 crc;
    crc.add_bytes(damaged);
    REQUIRE(crc.value() != whole.value());
  }
}
