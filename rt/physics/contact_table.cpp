#include "rt/physics/contact_table.h"

#include <algorithm>
#include <cmath>

namespace tactus::physics {
namespace {

constexpr std::uint32_t kNone = 0xffffffffu;

}  // namespace

template <class T>
ContactTable<T>::ContactTable(const Capacities& capacities)
    : pairs_(capacities.pairs),
      found_(capacities.pairs),
      order_(capacities.pairs),
      contacts_(capacities.contacts),
      last_(capacities.contacts),
      warm_starts_(capacities.contacts),
      warm_start_order_(capacities.contacts) {}

template <class T>
void ContactTable<T>::clear_pairs() noexcept {
  pairs_.clear();
  pairs_are_heap_ = false;
  pairs_dropped_ = 0;
}

// Beyond the capacity the pairs are a heap with the highest key on top: the one that gives way.
template <class T>
void ContactTable<T>::add_pair(PairKey key, std::uint32_t a, std::uint32_t b) noexcept {
  const Pair pair{key, a, b};
  if (pairs_.try_push(pair)) return;
  ++pairs_dropped_;
  if (pairs_.empty()) return;
  const auto lower_key = [](const Pair& p, const Pair& q) { return p.key < q.key; };
  if (!pairs_are_heap_) std::make_heap(pairs_.begin(), pairs_.end(), lower_key);
  pairs_are_heap_ = true;
  if (!(key < pairs_[0].key)) return;
  std::pop_heap(pairs_.begin(), pairs_.end(), lower_key);
  pairs_[pairs_.size() - 1] = pair;
  std::push_heap(pairs_.begin(), pairs_.end(), lower_key);
}

// Keys are distinct once duplicates are gone, and duplicates are equal, so the result does not depend on how they came.
template <class T>
void ContactTable<T>::sort_pairs() noexcept {
  const auto lower_key = [](const Pair& p, const Pair& q) { return p.key < q.key; };
  if (!std::is_sorted(pairs_.begin(), pairs_.end(), lower_key)) std::sort(pairs_.begin(), pairs_.end(), lower_key);
  Pair* end = std::unique(pairs_.begin(), pairs_.end(), [](const Pair& p, const Pair& q) { return p.key == q.key; });
  pairs_.resize(static_cast<std::uint32_t>(end - pairs_.begin()));
}

template <class T>
void ContactTable<T>::sort_warm_starts() noexcept {
  warm_start_order_.resize(warm_starts_.size());
  for (std::uint32_t i = 0; i < warm_starts_.size(); ++i) warm_start_order_[i] = i;
  std::sort(warm_start_order_.begin(), warm_start_order_.end(), [this](std::uint32_t i, std::uint32_t j) {
    return warm_starts_[i].key != warm_starts_[j].key ? warm_starts_[i].key < warm_starts_[j].key : i < j;
  });
}

// Pairs, last contacts and given impulses are all sorted by key: one merge walks the three.
template <class T>
void ContactTable<T>::find_manifolds(const Scene& scene, const StepSettings<T>& settings) noexcept {
  found_.clear();
  std::uint32_t last = 0, given = 0;
  for (const Pair& pair : pairs_) {
    while (last < last_.size() && last_[last].key < pair.key) ++last;
    while (given < warm_start_order_.size() && warm_starts_[warm_start_order_[given]].key < pair.key) ++given;
    const bool known = last < last_.size() && last_[last].key == pair.key;
    const bool told = given < warm_start_order_.size() && warm_starts_[warm_start_order_[given]].key == pair.key;

    const bool with_fixed = pair.key.with_fixed();
    const Body<T>& a = scene.bodies[pair.a];
    const Body<T>& b = with_fixed ? scene.fixed_bodies[pair.b] : scene.bodies[pair.b];
    // Two bodies fall side by side, or one of them is held: gravity counts once.
    const Reach<T> other = with_fixed ? Reach<T>{} : scene.reach[pair.b];
    const T reach = scene.reach[pair.a].moved + other.moved + std::max(scene.reach[pair.a].fallen, other.fallen);
    const T margin = std::min(std::max(settings.min_margin, reach), settings.max_margin);

    found_.resize(found_.size() + 1);  // as many as pairs at most
    Found& found = found_[found_.size() - 1];
    found.axis_cache = known  ? last_[last].axis_cache
                       : told ? warm_starts_[warm_start_order_[given]].axis_cache
                              : AxisCache{};
    found.manifold = collide(a.shape, a.motion.pose, b.shape, b.motion.pose, margin, found.axis_cache, scene.hulls);
    if (found.manifold.count == 0) {
      found_.resize(found_.size() - 1);
      continue;
    }
    found.pair = pair;
    found.last = known ? last : kNone;
    found.given = told ? warm_start_order_[given] : kNone;
    found.separation = found.manifold.points[0].separation;
    for (std::uint32_t i = 1; i < found.manifold.count; ++i)
      found.separation = std::min(found.separation, found.manifold.points[i].separation);
  }
}

// Leaves in order_ the indices of the manifolds that become contacts, ascending.
template <class T>
void ContactTable<T>::keep_deepest(StepReport<T>& report) noexcept {
  order_.resize(found_.size());
  for (std::uint32_t i = 0; i < found_.size(); ++i) order_[i] = i;
  if (found_.size() <= contacts_.capacity()) return;
  report.capacity_bits |= kContactsFull;
  report.dropped += found_.size() - contacts_.capacity();
  // found_ is in the order of keys, so the index decides ties as the key would.
  std::nth_element(
      order_.begin(), order_.begin() + contacts_.capacity(), order_.end(), [this](std::uint32_t i, std::uint32_t j) {
        return found_[i].separation != found_[j].separation ? found_[i].separation < found_[j].separation : i < j;
      });
  order_.resize(contacts_.capacity());
  std::sort(order_.begin(), order_.end());
}

template <class T>
Contact<T> ContactTable<T>::make_contact(const Found& found, const Scene& scene, T sub_step,
                                         T impulse_scale) const noexcept {
  const bool with_fixed = found.pair.key.with_fixed();
  const Body<T>& b = with_fixed ? scene.fixed_bodies[found.pair.b] : scene.bodies[found.pair.b];
  Contact<T> contact;
  contact.key = found.pair.key;
  contact.slot_a = found.pair.a, contact.slot_b = found.pair.b;
  contact.b_fixed = with_fixed;
  contact.axis_cache = found.axis_cache;
  contact.friction = std::sqrt(scene.bodies[found.pair.a].friction * b.friction);
  contact.normal = found.manifold.normal;
  contact.count = found.manifold.count;
  const Tangents<T> now = tangents_of(contact.normal);
  for (std::uint32_t i = 0; i < contact.count; ++i) {
    const ManifoldPoint<T>& made = found.manifold.points[i];
    ContactPoint<T>& point = contact.points[i];
    point = {};
    point.from_a = made.from_a, point.from_b = made.from_b;
    point.separation = made.separation;
    point.feature = made.feature;
    // The normal has turned since: the old friction vector is projected on the new tangents.
    const auto start_with = [&](T normal_impulse, const Vec3<T>& friction) {
      point.normal_impulse = normal_impulse;
      point.tangent_impulse[0] = dot(friction, now.t1), point.tangent_impulse[1] = dot(friction, now.t2);
    };
    if (found.last != kNone) {
      const Contact<T>& last = last_[found.last];
      const auto [s1, s2] = tangents_of(last.normal);
      for (std::uint32_t j = 0; j < last.count; ++j) {
        if (last.points[j].feature != point.feature) continue;
        start_with(last.points[j].normal_impulse,
                   last.points[j].tangent_impulse[0] * s1 + last.points[j].tangent_impulse[1] * s2);
        break;
      }
      if (impulse_scale != T(1)) {  // no multiplication when the sub-step stays: the bits stay too
        point.normal_impulse *= impulse_scale;
        point.tangent_impulse[0] *= impulse_scale, point.tangent_impulse[1] *= impulse_scale;
      }
    } else if (found.given != kNone) {
      const WarmStart<T>& given = warm_starts_[found.given];
      for (std::uint32_t j = 0; j < given.count; ++j) {
        if (given.features[j] != point.feature) continue;
        start_with(given.normal_force[j] * sub_step, given.friction_force[j] * sub_step);
        break;
      }
    }
  }
  return contact;
}

template <class T>
void ContactTable<T>::build(const Scene& scene, const StepSettings<T>& settings, T sub_step, T impulse_scale,
                            StepReport<T>& report) noexcept {
  sort_pairs();
  sort_warm_starts();
  if (pairs_dropped_ > 0) report.capacity_bits |= kPairsFull;
  report.dropped += pairs_dropped_;
  report.pairs = pairs_.size();

  last_.swap(contacts_);
  contacts_.clear();
  find_manifolds(scene, settings);
  keep_deepest(report);
  T smallest = T(0);
  contacts_.resize(order_.size());
  for (std::uint32_t i = 0; i < order_.size(); ++i) {
    const Found& found = found_[order_[i]];
    contacts_[i] = make_contact(found, scene, sub_step, impulse_scale);
    report.points += found.manifold.count;
    smallest = std::min(smallest, found.separation);
  }
  report.contacts = contacts_.size();
  report.deepest_m = -smallest;
  warm_starts_.clear();
}

template <class T>
void ContactTable<T>::slot_inserted(std::uint32_t slot, bool fixed) noexcept {
  for (Contact<T>& contact : contacts_) {
    if (!fixed && contact.slot_a >= slot) ++contact.slot_a;
    if (contact.b_fixed == fixed && contact.slot_b >= slot) ++contact.slot_b;
  }
}

template <class T>
void ContactTable<T>::slot_removed(std::uint32_t slot, bool fixed) noexcept {
  std::uint32_t kept = 0;
  for (std::uint32_t i = 0; i < contacts_.size(); ++i) {
    Contact<T>& contact = contacts_[i];
    const bool b_in_question = contact.b_fixed == fixed;
    if ((!fixed && contact.slot_a == slot) || (b_in_question && contact.slot_b == slot)) continue;
    if (!fixed && contact.slot_a > slot) --contact.slot_a;
    if (b_in_question && contact.slot_b > slot) --contact.slot_b;
    if (kept != i) contacts_[kept] = contact;
    ++kept;
  }
  contacts_.resize(kept);
}

template class ContactTable<double>;
template class ContactTable<float>;

}  // namespace tactus::physics
