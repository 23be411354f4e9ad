#include "rt/physics/collision/pair_order.h"

#include <algorithm>
#include <utility>

namespace tactus::physics {
namespace {

bool equal(const SlotPair& p, const SlotPair& q) noexcept { return p.a == q.a && p.b == q.b; }

}  // namespace

// Stable: pairs with equal slots keep their order.
template <std::uint32_t SlotPair::*kSlot>
void PairOrder::sort_by(const BoundedVector<SlotPair>& from, BoundedVector<SlotPair>& to,
                        std::uint32_t slots) noexcept {
  begin_.resize(slots + 1);
  std::fill(begin_.begin(), begin_.end(), 0u);
  for (const SlotPair& pair : from) ++begin_[pair.*kSlot + 1];
  for (std::uint32_t i = 1; i <= slots; ++i) begin_[i] += begin_[i - 1];
  to.resize(from.size());
  for (const SlotPair& pair : from) to[begin_[pair.*kSlot]++] = pair;
}

void PairOrder::sort(BoundedVector<SlotPair>& pairs, std::uint32_t slots) noexcept {
  bool ascending = true;
  SlotPair last{};
  for (std::uint32_t i = 0; i < pairs.size(); ++i) {
    SlotPair& pair = pairs[i];
    if (pair.a > pair.b) std::swap(pair.a, pair.b);
    ascending = ascending && (i == 0 || last.a < pair.a || (last.a == pair.a && last.b < pair.b));
    last = pair;
  }
  if (ascending) return;
  sort_by<&SlotPair::b>(pairs, other_, slots);
  sort_by<&SlotPair::a>(other_, pairs, slots);
  pairs.resize(static_cast<std::uint32_t>(std::unique(pairs.begin(), pairs.end(), equal) - pairs.begin()));
}

}  // namespace tactus::physics
