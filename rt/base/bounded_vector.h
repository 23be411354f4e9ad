// Containers of fixed capacity: BoundedVector at construction, FixedVector in the type.
//
// Thread: construction is [setup]; everything else is [rt] and never allocates.
// Bound: `try_push` returns false at capacity and changes nothing; the caller sets its capacity bit and counts.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <type_traits>

#include "rt/base/check.h"

namespace tactus {

template <class T>
class BoundedVector {
  static_assert(std::is_trivially_destructible_v<T>, "elements are overwritten, never destroyed");

 public:
  BoundedVector() = default;
  explicit BoundedVector(std::uint32_t capacity)  // [setup] allocates and touches every element
      : data_(std::make_unique<T[]>(capacity)), capacity_(capacity) {}
  BoundedVector(const BoundedVector& other) : BoundedVector(other.capacity_) {  // [setup], as the assignment
    std::copy(other.begin(), other.end(), begin());
    size_ = other.size_;
  }
  BoundedVector(BoundedVector&& other) noexcept { swap(other); }
  BoundedVector& operator=(BoundedVector other) noexcept {
    swap(other);
    return *this;
  }

  [[nodiscard]] bool try_push(const T& value) noexcept {
    if (size_ == capacity_) return false;
    data_[size_++] = value;
    return true;
  }
  // Inserts before `index`, moving the rest up.
  [[nodiscard]] bool try_insert(std::uint32_t index, const T& value) noexcept {
    TACTUS_CHECK(index <= size_, index, size_);
    if (size_ == capacity_) return false;
    std::copy_backward(begin() + index, end(), end() + 1);
    data_[index] = value;
    ++size_;
    return true;
  }
  void erase(std::uint32_t index) noexcept {
    TACTUS_CHECK(index < size_, index, size_);
    std::copy(begin() + index + 1, end(), begin() + index);
    --size_;
  }
  void clear() noexcept { size_ = 0; }
  void resize(std::uint32_t size) noexcept {  // elements that become visible keep their former value
    TACTUS_CHECK(size <= capacity_, size, capacity_);
    size_ = size;
  }
  void swap(BoundedVector& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    std::swap(capacity_, other.capacity_);
  }

  T& operator[](std::uint32_t i) noexcept { return data_[i]; }
  const T& operator[](std::uint32_t i) const noexcept { return data_[i]; }
  std::uint32_t size() const noexcept { return size_; }
  std::uint32_t capacity() const noexcept { return capacity_; }
  bool empty() const noexcept { return size_ == 0; }
  bool full() const noexcept { return size_ == capacity_; }
  T* begin() noexcept { return data_.get(); }
  T* end() noexcept { return data_.get() + size_; }
  const T* begin() const noexcept { return data_.get(); }
  const T* end() const noexcept { return data_.get() + size_; }
  std::span<T> span() noexcept { return {begin(), size_}; }
  std::span<const T> span() const noexcept { return {begin(), size_}; }

 private:
  std::unique_ptr<T[]> data_;
  std::uint32_t size_{0}, capacity_{0};
};

// Trivially copyable, so that it can cross a thread.
template <class T, std::uint32_t kCapacity>
struct FixedVector {
  std::uint32_t count{0};
  std::array<T, kCapacity> items;

  [[nodiscard]] bool try_push(const T& value) noexcept {
    if (count == kCapacity) return false;
    items[count++] = value;
    return true;
  }
  void clear() noexcept { count = 0; }
  T& operator[](std::uint32_t i) noexcept { return items[i]; }
  const T& operator[](std::uint32_t i) const noexcept { return items[i]; }
  std::uint32_t size() const noexcept { return count; }
  static constexpr std::uint32_t capacity() noexcept { return kCapacity; }
  bool empty() const noexcept { return count == 0; }
  T* begin() noexcept { return items.data(); }
  T* end() noexcept { return items.data() + count; }
  const T* begin() const noexcept { return items.data(); }
  const T* end() const noexcept { return items.data() + count; }
  std::span<T> span() noexcept { return {items.data(), count}; }
  std::span<const T> span() const noexcept { return {items.data(), count}; }
};

}  // namespace tactus
