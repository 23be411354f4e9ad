#include "firmware/service.h"

#include <catch2/catch.hpp>
#include <random>

using namespace tactus::firmware;

namespace {

ServiceMessage random_message(std::mt19937_64& random) {
  ServiceMessage m;
  m.operation = static_cast<Operation>(random() % 16);
  m.status = static_cast<ServiceStatus>(random() % 16);
  m.tag = static_cast<std::uint8_t>(random());
  m.address = static_cast<std::uint16_t>(random());
  m.value = static_cast<std::uint32_t>(random());
  return m;
}

}  // namespace

TEST_CASE("a decoded service message is the one that was encoded, in its own direction only") {
  std::mt19937_64 random(1);
  for (int i = 0; i < 10000; ++i) {
    const ServiceMessage sent = random_message(random);
    const auto direction = random() % 2 == 0 ? ServiceDirection::kRequest : ServiceDirection::kReply;
    const auto other = direction == ServiceDirection::kReply ? ServiceDirection::kRequest : ServiceDirection::kReply;
    std::array<std::byte, kServiceFrameSize> bytes{};
    encode_service(sent, direction, bytes);
    ServiceMessage came;
    REQUIRE(decode_service(bytes, other, came) == DecodeError::kWrongType);
    REQUIRE(came == ServiceMessage{});
    REQUIRE(decode_service(bytes, direction, came) == DecodeError::kNone);
    REQUIRE(came == sent);
    std::array<std::byte, kServiceContentSize> content{};
    encode_service_content(sent, content);
    REQUIRE(std::equal(content.begin(), content.end(), bytes.begin() + 4));
    REQUIRE(decode_service_content(content, came));
    REQUIRE(came == sent);
  }
}

TEST_CASE("every flipped bit of a service message is found, and every other length refused") {
  std::mt19937_64 random(2);
  std::array<std::byte, kServiceFrameSize> bytes{};
  encode_service(random_message(random), ServiceDirection::kRequest, bytes);
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    auto flipped = bytes;
    flipped[bit / 8] ^= static_cast<std::byte>(1u << (bit % 8));
    ServiceMessage came;
    REQUIRE(decode_service(flipped, ServiceDirection::kRequest, came) != DecodeError::kNone);
    REQUIRE(came == ServiceMessage{});
  }
  ServiceMessage came;
  for (std::size_t size = 0; size < bytes.size(); ++size)
    CHECK(decode_service(std::span(bytes).first(size), ServiceDirection::kRequest, came) == DecodeError::kWrongSize);
  CHECK_FALSE(decode_service_content(std::span(bytes).first(7), came));
}

TEST_CASE("the content is at the offsets of the layout") {
  std::array<std::byte, kServiceContentSize> b{};
  encode_service_content({.operation = Operation::kWrite,
                          .status = ServiceStatus::kWrongState,
                          .tag = 0x51,
                          .address = 0x1234,
                          .value = 0x44434241u},
                         b);
  const std::array<unsigned, 8> expected{0x42, 0x51, 0x34, 0x12, 0x41, 0x42, 0x43, 0x44};
  for (std::size_t i = 0; i < 8; ++i) CHECK(std::to_integer<unsigned>(b[i]) == expected[i]);
}
