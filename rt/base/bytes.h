// Writes plain values into bytes and reads them back: for keyframes and tapes.
//
// Thread: [rt]. Bound: nothing is written or read beyond the span; `ok()` turns false instead and stays false.
// Values must be trivially copyable; values that are hashed or compared must have no indeterminate padding.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>

namespace tactus {

class ByteWriter {
 public:
  explicit ByteWriter(std::span<std::byte> out) noexcept : out_(out) {}

  template <class T>
  void put(const T& value) noexcept {
    put_all(std::span<const T>(&value, 1));
  }

  template <class T>
  void put_all(std::span<const T> values) noexcept {
    static_assert(std::is_trivially_copyable_v<T>);
    const std::size_t size = values.size_bytes();
    if (!ok_ || size > out_.size() - used_) {
      ok_ = false;
      return;
    }
    if (size > 0) std::memcpy(out_.data() + used_, values.data(), size);
    used_ += size;
  }

  std::size_t size() const noexcept { return used_; }
  bool ok() const noexcept { return ok_; }

 private:
  std::span<std::byte> out_;
  std::size_t used_{0};
  bool ok_{true};
};

class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> in) noexcept : in_(in) {}

  template <class T>
  void get(T& value) noexcept {
    get_all(std::span<T>(&value, 1));
  }

  template <class T>
  void get_all(std::span<T> values) noexcept {
    static_assert(std::is_trivially_copyable_v<T>);
    const std::size_t size = values.size_bytes();
    if (!ok_ || size > in_.size() - used_) {
      ok_ = false;
      return;
    }
    if (size > 0) std::memcpy(values.data(), in_.data() + used_, size);
    used_ += size;
  }

  std::size_t remaining() const noexcept { return in_.size() - used_; }
  bool ok() const noexcept { return ok_; }

 private:
  std::span<const std::byte> in_;
  std::size_t used_{0};
  bool ok_{true};
};

}  // namespace tactus
