// Equality of representation, where == would take 0 for -0 and NaN for unequal to itself.
#pragma once

#include <cstring>
#include <type_traits>

namespace tactus::test {

template <class T>
bool same_bits(const T& a, const T& b) {
  static_assert(std::is_trivially_copyable_v<T>);
  return std::memcmp(&a, &b, sizeof(T)) == 0;
}

}  // namespace tactus::test
