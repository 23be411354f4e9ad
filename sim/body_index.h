// The index of a moving body of the scene: its rank by id among all of them, awake or asleep.
//
// A world has another index, the slot (rt/physics/slot_index.h): the rank among the bodies in that world, which are the
// awake ones. Slots change when a body falls asleep, and equal values of a slot and a BodyIndex need not mean the same
// body. Therefore each is a type of its own: neither converts to the other, to an id or to an integer, and a BodySpan
// or BodyVector is indexed by BodyIndex only. IslandManager::awake() maps slots to body indices. Costs no instruction.
// Thread: [any].
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

namespace tactus::sim {

enum class BodyIndex : std::uint32_t {};

constexpr std::uint32_t number_of(BodyIndex body) noexcept { return static_cast<std::uint32_t>(body); }
constexpr BodyIndex& operator++(BodyIndex& body) noexcept { return body = BodyIndex{number_of(body) + 1}; }

// The body indices below a bound, in order: for (const BodyIndex body : BodyIndices(count)).
class BodyIndices {
 public:
  explicit constexpr BodyIndices(std::size_t count) noexcept : end_{BodyIndex{static_cast<std::uint32_t>(count)}} {}

  struct Iterator {
    BodyIndex at;
    constexpr BodyIndex operator*() const noexcept { return at; }
    constexpr Iterator& operator++() noexcept {
      ++at;
      return *this;
    }
    friend constexpr bool operator==(const Iterator&, const Iterator&) noexcept = default;
  };
  constexpr Iterator begin() const noexcept { return {BodyIndex{0}}; }
  constexpr Iterator end() const noexcept { return end_; }

 private:
  Iterator end_;
};

// A view of values by body index.
template <class T>
class BodySpan {
 public:
  constexpr BodySpan() = default;
  explicit constexpr BodySpan(std::span<T> values) noexcept : values_(values) {}
  template <class U, class = std::enable_if_t<std::is_same_v<const U, T>>>
  constexpr BodySpan(const BodySpan<U>& other) noexcept : values_(other.span()) {}

  constexpr T& operator[](BodyIndex body) const noexcept { return values_[number_of(body)]; }
  constexpr std::size_t size() const noexcept { return values_.size(); }
  constexpr bool empty() const noexcept { return values_.empty(); }
  constexpr BodyIndices indices() const noexcept { return BodyIndices(values_.size()); }
  constexpr auto begin() const noexcept { return values_.begin(); }
  constexpr auto end() const noexcept { return values_.end(); }
  constexpr std::span<T> span() const noexcept { return values_; }

 private:
  std::span<T> values_;
};

// Values by body index. Construction and assign() allocate.
template <class T>
class BodyVector {
 public:
  BodyVector() = default;
  explicit BodyVector(std::size_t count, const T& value = T()) : values_(count, value) {}
  explicit BodyVector(std::vector<T> values) : values_(std::move(values)) {}

  T& operator[](BodyIndex body) noexcept { return values_[number_of(body)]; }
  const T& operator[](BodyIndex body) const noexcept { return values_[number_of(body)]; }
  std::size_t size() const noexcept { return values_.size(); }
  BodyIndices indices() const noexcept { return BodyIndices(values_.size()); }
  void fill(const T& value) noexcept { std::fill(values_.begin(), values_.end(), value); }
  operator BodySpan<T>() noexcept { return BodySpan<T>(values_); }
  operator BodySpan<const T>() const noexcept { return BodySpan<const T>(values_); }
  std::span<const T> span() const noexcept { return values_; }
  auto begin() const noexcept { return values_.begin(); }
  auto end() const noexcept { return values_.end(); }

 private:
  std::vector<T> values_;
};

}  // namespace tactus::sim
