#include "rt/physics/pair_finder.h"

namespace tactus::physics {

template <class T>
bool find_pairs_brute_force(std::span<const Aabb<T>> bounds, BoundedVector<SlotPair>& pairs) noexcept {
  const auto count = static_cast<std::uint32_t>(bounds.size());
  for (std::uint32_t a = 0; a < count; ++a)
    for (std::uint32_t b = a + 1; b < count; ++b)
      if (bounds[a].overlaps(bounds[b]) && !pairs.try_push({a, b})) return false;
  return true;
}

template bool find_pairs_brute_force(std::span<const Aabb<double>>, BoundedVector<SlotPair>&) noexcept;
template bool find_pairs_brute_force(std::span<const Aabb<float>>, BoundedVector<SlotPair>&) noexcept;

}  // namespace tactus::physics
