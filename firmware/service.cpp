#include "firmware/service.h"

#include <algorithm>

#include "firmware/little_endian.h"

namespace tactus::firmware {
namespace {

constexpr std::size_t kContentOffset = 4, kCrcOffset = 12;

}  // namespace

void encode_service_content(const ServiceMessage& message, std::span<std::byte, kServiceContentSize> out) noexcept {
  const auto operation = static_cast<unsigned>(message.operation) & 0xfu;
  const auto status = static_cast<unsigned>(message.status) & 0xfu;
  put<std::uint8_t>(out, 0, static_cast<std::uint8_t>(operation | (status << 4)));
  put<std::uint8_t>(out, 1, message.tag);
  put<std::uint16_t>(out, 2, message.address);
  put<std::uint32_t>(out, 4, message.value);
}

bool decode_service_content(std::span<const std::byte> bytes, ServiceMessage& message) noexcept {
  if (bytes.size() != kServiceContentSize) return false;
  const unsigned first = get<std::uint8_t>(bytes, 0);
  message.operation = static_cast<Operation>(first & 0xfu);
  message.status = static_cast<ServiceStatus>(first >> 4);
  message.tag = get<std::uint8_t>(bytes, 1);
  message.address = get<std::uint16_t>(bytes, 2);
  message.value = get<std::uint32_t>(bytes, 4);
  return true;
}

void encode_service(const ServiceMessage& message, ServiceDirection direction,
                    std::span<std::byte, kServiceFrameSize> out) noexcept {
  put<std::uint8_t>(out, 0, kMagic);
  put<std::uint8_t>(out, 1, kProtocolVersion);
  put<std::uint8_t>(out, 2, static_cast<std::uint8_t>(direction));
  put<std::uint8_t>(out, 3, 0);
  encode_service_content(message, out.subspan<kContentOffset, kServiceContentSize>());
  put<std::uint32_t>(out, kCrcOffset, crc32c(out.first<kCrcOffset>()));
}

DecodeError decode_service(std::span<const std::byte> bytes, ServiceDirection direction,
                           ServiceMessage& message) noexcept {
  if (bytes.size() != kServiceFrameSize) return DecodeError::kWrongSize;
  if (get<std::uint8_t>(bytes, 0) != kMagic) return DecodeError::kWrongMagic;
  if (get<std::uint32_t>(bytes, kCrcOffset) != crc32c(bytes.first(kCrcOffset))) return DecodeError::kWrongCrc;
  if (get<std::uint8_t>(bytes, 1) != kProtocolVersion) return DecodeError::kWrongVersion;
  if (get<std::uint8_t>(bytes, 2) != static_cast<std::uint8_t>(direction)) return DecodeError::kWrongType;
  if (get<std::uint8_t>(bytes, 3) != 0) return DecodeError::kReservedNotZero;
  (void)decode_service_content(bytes.subspan(kContentOffset, kServiceContentSize), message);
  return DecodeError::kNone;
}

}  // namespace tactus::firmware
