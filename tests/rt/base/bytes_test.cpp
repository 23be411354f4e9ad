#include "rt/base/bytes.h"

#include <array>
#include <catch2/catch.hpp>

using namespace tactus;

TEST_CASE("values come back as they were written, in order", "[base]") {
  std::array<std::byte, 64> bytes{};
  ByteWriter writer(bytes);
  const std::array<float, 3> numbers{1.f, 2.f, 3.f};
  writer.put(std::uint8_t{7});
  writer.put(0.1);
  writer.put_all(std::span<const float>(numbers));
  REQUIRE(writer.ok());
  CHECK(writer.size() == 1 + 8 + 12);

  ByteReader reader(std::span<const std::byte>(bytes).first(writer.size()));
  std::uint8_t small = 0;
  double number = 0;
  std::array<float, 3> read{};
  reader.get(small);
  reader.get(number);
  reader.get_all(std::span<float>(read));
  CHECK(reader.ok());
  CHECK(reader.remaining() == 0);
  CHECK(small == 7);
  CHECK(number == 0.1);
  CHECK(read == numbers);
}

TEST_CASE("nothing is written or read beyond the span, and the failure stays", "[base]") {
  std::array<std::byte, 8> bytes{};
  bytes[7] = std::byte{0xaa};
  ByteWriter writer{std::span(bytes).first(7)};
  writer.put(std::uint32_t{1});
  writer.put(std::uint32_t{0xffffffff});
  CHECK(!writer.ok());
  CHECK(writer.size() == 4);
  writer.put(std::uint8_t{1});  // would fit
  CHECK(!writer.ok());
  CHECK(writer.size() == 4);
  CHECK(bytes[4] == std::byte{0});
  CHECK(bytes[7] == std::byte{0xaa});

  ByteReader reader(std::span<const std::byte>(bytes).first(6));
  std::uint32_t value = 0;
  reader.get(value);
  CHECK(value == 1);
  value = 5;
  reader.get(value);
  CHECK(!reader.ok());
  CHECK(value == 5);
  std::uint8_t small = 6;
  reader.get(small);  // would be there
  CHECK(!reader.ok());
  CHECK(small == 6);
}
