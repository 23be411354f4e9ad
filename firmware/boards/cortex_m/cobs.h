// Framing on a serial line: consistent overhead byte stuffing (COBS). Encoded frames contain no zeros, so a zero on the
// line always ends a frame, and a receiver resynchronises at the next zero after any start or damage.
//
// A block is a code n from 1 to 255 and n - 1 bytes that are not zero; it encodes these bytes and a following zero,
// which the last block does not have. Frames here are shorter than 255 bytes, so a code of 255 never occurs and a frame
// grows by two bytes: its first code and the terminating zero. The content is a frame of protocol.h or service.h.
// Source: Cheshire and Baker, "Consistent Overhead Byte Stuffing", 1999. Thread: [any]. Bound: kMaxFrameSize.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/protocol.h"

namespace tactus::firmware {

inline constexpr std::size_t kMaxStuffedSize = kMaxFrameSize + 2;

// Returns the size, `frame.size() + 2`. A frame beyond kMaxFrameSize gives 0.
inline std::size_t stuff(std::span<const std::byte> frame, std::span<std::byte, kMaxStuffedSize> out) noexcept {
  if (frame.size() > kMaxFrameSize) return 0;
  std::size_t code_at = 0, size = 1;
  for (const std::byte b : frame) {
    if (b == std::byte{0}) {
      out[code_at] = static_cast<std::byte>(size - code_at);
      code_at = size;
    } else {
      out[size] = b;
    }
    ++size;
  }
  out[code_at] = static_cast<std::byte>(size - code_at);
  out[size] = std::byte{0};
  return size + 1;
}

// Decodes the line byte by byte.
class FrameReader {
 public:
  // True if this byte ends a frame: frame() returns it until the next call. Empty frames are ignored; corrupt or too
  // long ones are counted.
  bool accept(std::byte b) noexcept {
    if (complete_) {
      complete_ = false;
      size_ = 0;
    }
    if (b == std::byte{0}) {
      const bool began = begun_, whole = !broken_ && left_ == 0 && size_ > 0;
      begun_ = broken_ = false;
      left_ = 0;
      complete_ = began && whole;
      if (began && !whole && malformed_ != ~std::uint32_t{0}) ++malformed_;
      if (!complete_) size_ = 0;
      return complete_;
    }
    if (broken_) return false;
    if (left_ > 0) {
      --left_;
      append(b);
      return false;
    }
    if (begun_) append(std::byte{0});  // the zero between two blocks
    begun_ = true;
    left_ = std::to_integer<std::size_t>(b) - 1;
    return false;
  }

  std::span<const std::byte> frame() const noexcept { return std::span<const std::byte>(bytes_).first(size_); }
  std::uint32_t malformed() const noexcept { return malformed_; }  // saturates

 private:
  void append(std::byte b) noexcept {
    if (size_ < bytes_.size())
      bytes_[size_++] = b;
    else
      broken_ = true;
  }

  std::array<std::byte, kMaxFrameSize> bytes_{};
  std::size_t size_{0}, left_{0};  // left_: outstanding bytes of the block
  bool begun_{false}, broken_{false}, complete_{false};
  std::uint32_t malformed_{0};
};

}  // namespace tactus::firmware
