#include "rt/physics/contact/contact_table.h"

#include <algorithm>

#include "rt/physics/collision/collide.h"
#include "rt/physics/collision/mesh_culling.h"
#include "rt/physics/contact/find_contacts.h"
#include "rt/physics/contact/pair_friction.h"
#include "rt/physics/contact/redundant_points.h"
#include "rt/physics/contact/rolling_side.h"
#include "rt/physics/contact/start_impulses.h"

namespace tactus::physics {
namespace {

// Not called if the sub-step is unchanged, so that the bits stay the same.
void scale_impulses(ContactPoint& point, double factor) noexcept {
  point.normal_impulse *= factor;
  point.tangent_impulse[0] *= factor;
  point.tangent_impulse[1] *= factor;
}

LastFeatures features_of(const Contact* last, const WarmStart* given) noexcept {
  if (last == nullptr) return given != nullptr ? LastFeatures{given->count, given->features} : LastFeatures{};
  LastFeatures features{last->count, {}};
  for (std::uint32_t i = 0; i < last->count; ++i) features.of[i] = last->points[i].feature;
  return features;
}

// Points are wanted up to this separation [m], if the step may take `closing` from it.
double margin_for(bool with_patch, double closing, const StepSettings& settings) noexcept {
  return with_patch ? patch_margin(closing, settings)
                    : std::max(settings.min_margin, closing + carry_over_margin(settings));
}

constexpr MotionBound kStill{};  // of a fixed body

// Of a body and a patch keeps the points whose gap this step may close. A body on rough ground is near many patches and
// touches few; its contacts with them are not carried over, so their points are found anew in the next step.
void drop_points_out_of_reach(const MotionBound& body, const StepSettings& settings, Manifold& manifold) noexcept {
  const Vec3d& n = manifold.normal;
  const auto in_reach = [&](const ManifoldPoint& point) noexcept {
    if (point.separation <= 0.0) return true;
    const double by_turn = dot(cross(body.turn, point.from_a), n);
    return point.separation <= patch_margin(closing_to_fixed(body, n, by_turn, settings), settings);
  };
  keep_points(in_reach, manifold);
}

// Number of pairs visited at a time: enough to share their searches, few enough to stay in the cache.
constexpr std::uint32_t kStretch = 256;
// A search takes about 1 us, and so does handing it to another thread.
constexpr std::uint32_t kMinSearches = 4;

}  // namespace

// The contacts of this step overwrite those of the last: usually the same pairs touch, and each contact keeps its
// place. When a new contact must be inserted, those written so far move to last_, and the rest are written there.
struct ContactTable::Walk {
  const Scene& scene;
  const StepSettings& settings;
  double sub_step, impulse_scale;
  const Contact* old;  // contacts of the last step
  const ContactReference* old_references;
  std::uint32_t old_count, old_next{0};  // contacts of the last step: their number, the next to be read
  Contact* contacts;                     // of this step: in place of the old ones, or in last_
  ContactReference* references;
  std::uint32_t written{0};
  std::uint32_t last_pair{0}, old_seen{0}, given{0};
  std::uint32_t visits{0}, searches{0};       // of the present block of pairs
  std::uint32_t searched{0}, comparisons{0};  // as in StepReport
};

ContactTable::ContactTable(const Capacities& capacities)
    : pairs_(capacities.pairs),
      last_pairs_(capacities.pairs),
      visits_(kStretch),
      searches_(kStretch),
      manifolds_(kStretch),
      contacts_(capacities.contacts),
      last_(capacities.contacts),
      references_(capacities.contacts),
      last_references_(capacities.contacts),
      beyond_(capacities.pairs > capacities.contacts ? capacities.pairs - capacities.contacts : 0),
      order_(std::max(capacities.pairs, capacities.contacts)),
      warm_starts_(capacities.contacts),
      warm_start_order_(capacities.contacts),
      seams_(capacities) {
  visits_.resize(kStretch);
  searches_.resize(kStretch);
  manifolds_.resize(kStretch);
}

void ContactTable::clear() noexcept {
  pairs_.clear();
  clear_pairs();
  contacts_.clear();
  references_.clear();
  warm_starts_.clear();
}

void ContactTable::clear_pairs() noexcept {
  last_pairs_.swap(pairs_);
  pairs_.clear();
  pairs_are_heap_ = false;
  pairs_dropped_ = 0;
}

// When the list is full, the pairs form a heap with the next to be dropped on top: the pair of moving bodies with the
// highest key. Pairs with fixed bodies are dropped last, so that no body falls through the ground because other bodies
// are crowded.
void ContactTable::add_pair(PairKey key, std::uint32_t a, std::uint32_t b, const PatchTriangles& patch) noexcept {
  const Pair pair{.key = key, .a = a, .b = b, .patch = patch};
  if (pairs_.try_push(pair)) return;
  ++pairs_dropped_;
  if (pairs_.empty()) return;
  const auto kept_before = [](const Pair& p, const Pair& q) {
    return p.key.with_fixed() != q.key.with_fixed() ? p.key.with_fixed() : p.key < q.key;
  };
  if (!pairs_are_heap_) std::make_heap(pairs_.begin(), pairs_.end(), kept_before);
  pairs_are_heap_ = true;
  if (!kept_before(pair, pairs_[0])) return;
  std::pop_heap(pairs_.begin(), pairs_.end(), kept_before);
  pairs_[pairs_.size() - 1] = pair;
  std::push_heap(pairs_.begin(), pairs_.end(), kept_before);
}

// Keys are distinct after duplicates are removed, and duplicates are equal, so the result does not depend on the input
// order. Usually the world adds the pairs sorted.
void ContactTable::sort_pairs() noexcept {
  const auto lower_key = [](const Pair& p, const Pair& q) { return p.key < q.key; };
  const auto not_ascending = [](const Pair& p, const Pair& q) { return !(p.key < q.key); };
  if (std::adjacent_find(pairs_.begin(), pairs_.end(), not_ascending) == pairs_.end()) return;
  std::sort(pairs_.begin(), pairs_.end(), lower_key);
  Pair* end = std::unique(pairs_.begin(), pairs_.end(), [](const Pair& p, const Pair& q) { return p.key == q.key; });
  pairs_.resize(static_cast<std::uint32_t>(end - pairs_.begin()));
}

void ContactTable::sort_warm_starts() noexcept {
  warm_start_order_.resize(warm_starts_.size());
  for (std::uint32_t i = 0; i < warm_starts_.size(); ++i) warm_start_order_[i] = i;
  std::sort(warm_start_order_.begin(), warm_start_order_.end(), [this](std::uint32_t i, std::uint32_t j) {
    return warm_starts_[i].key != warm_starts_[j].key ? warm_starts_[i].key < warm_starts_[j].key : i < j;
  });
}

// Merges pairs of this step and the last, contacts of the last and given impulses, all sorted by key. It runs one block
// of pairs ahead of the writing of contacts, and writes none itself.
void ContactTable::visit(Walk& walk, std::uint32_t index) noexcept {
  Pair& pair = pairs_[index];
  const bool with_fixed = pair.key.with_fixed();
  const MotionBound& a = walk.scene.motion_bounds[pair.a];
  const MotionBound& b = with_fixed ? kStill : walk.scene.motion_bounds[pair.b];
  const double margin = margin_for(pair.patch.count > 0, closing_of(a, b, walk.settings), walk.settings);

  while (walk.last_pair < last_pairs_.size() && last_pairs_[walk.last_pair].key < pair.key) ++walk.last_pair;
  if (walk.last_pair < last_pairs_.size() && last_pairs_[walk.last_pair].key == pair.key) {
    const Pair& last = last_pairs_[walk.last_pair];
    pair.gap = last.gap - moved_against(a, b, last.lever_arm);
    pair.lever_arm = last.lever_arm;
    pair.apart = last.apart;
    if (pair.gap > margin) return;
  }
  pair.gap = pair.lever_arm = 0.0;

  while (walk.old_seen < walk.old_count && walk.old[walk.old_seen].key < pair.key) ++walk.old_seen;
  const bool known = walk.old_seen < walk.old_count && walk.old[walk.old_seen].key == pair.key;
  const WarmStart* given = nullptr;
  if (!warm_starts_.empty()) {
    const auto of = [&](std::uint32_t i) -> const WarmStart& { return warm_starts_[warm_start_order_[i]]; };
    while (walk.given < warm_starts_.size() && of(walk.given).key < pair.key) ++walk.given;
    if (walk.given < warm_starts_.size() && of(walk.given).key == pair.key) given = &of(walk.given);
  }
  Visit& visit = visits_[walk.visits++];
  visit.pair = index;
  visit.old = walk.old_seen;
  if (known && walk.settings.recycle_tolerance_m > 0.0) {
    const ContactReference& reference = walk.old_references[walk.old_seen];
    visit.moved = reference.moved + moved_against(a, b, reference.lever_arm);
    visit.search = kCarryOver;
    if (may_carry_over(reference, visit.moved, closing_along(walk.old[walk.old_seen].normal, a, b, walk.settings)))
      return;
  }
  visit.search = walk.searches++;
  Search& search = searches_[visit.search];
  search.pair = index;
  search.known = known;
  search.given = given;
  search.query.margin = margin;
  search.query.last = features_of(known ? &walk.old[walk.old_seen] : nullptr, given);
  search.query.apart = pair.apart;
  pair.apart = {};
  search.axis_cache = known ? walk.old[walk.old_seen].axis_cache : given ? given->axis_cache : AxisCache{};
}

// Carries the next contact over and updates its points to the bodies' present poses.
void ContactTable::keep(Walk& walk, const Visit& visit) noexcept {
  const Pair& pair = pairs_[visit.pair];
  const Contact* last = &walk.old[visit.old];
  const ContactReference* last_reference = &walk.old_references[visit.old];
  walk.old_next = visit.old + 1;
  Contact* contact = place(walk);  // fits: it was there before
  ContactReference& reference = walk.references[walk.written - 1];
  if (contact != last) {
    *contact = *last;
    reference = *last_reference;
  }
  for (ContactPoint& point : contact->points) point.redundant = false;
  reference.moved = visit.moved;
  contact->slot_a = pair.a;
  contact->slot_b = pair.b;
  const auto& frame_b = contact->b_fixed ? walk.scene.fixed_frames[pair.b] : walk.scene.frames[pair.b];
  carry_over(reference, walk.scene.frames[pair.a], frame_b, *contact);
  if (walk.impulse_scale != 1.0)
    for (std::uint32_t i = 0; i < contact->count; ++i) scale_impulses(contact->points[i], walk.impulse_scale);
}

// Returns where the next contact of this step is written.
Contact* ContactTable::place(Walk& walk) noexcept {
  if (walk.contacts == walk.old && walk.written == walk.old_next && walk.old_next < walk.old_count) {
    std::copy(walk.contacts, walk.contacts + walk.written, last_.begin());
    std::copy(walk.references, walk.references + walk.written, last_references_.begin());
    walk.contacts = last_.begin();
    walk.references = last_references_.begin();
  }
  if (walk.written < contacts_.capacity()) return &walk.contacts[walk.written++];
  beyond_.resize(beyond_.size() + 1);  // fits: there are at most as many contacts as pairs
  return &beyond_[beyond_.size() - 1];
}

void ContactTable::take_found(Walk& walk, const Visit& visit, const Search& search, Manifold& manifold) noexcept {
  Pair& pair = pairs_[visit.pair];
  const auto set_apart = [&]() noexcept {
    pair.gap = manifold.gap;
    pair.lever_arm = manifold.lever_arm;
    pair.apart = manifold.apart;
  };
  if (manifold.count == 0) return set_apart();
  const bool with_fixed = pair.key.with_fixed();
  // The margin of the search covers motion in any direction. Now the normal is known: only motion along it counts.
  const MotionBound& bound_a = walk.scene.motion_bounds[pair.a];
  double margin = search.query.margin;
  if (pair.patch.count > 0) {
    drop_points_out_of_reach(bound_a, walk.settings, manifold);
  } else {
    const MotionBound& bound_b = with_fixed ? kStill : walk.scene.motion_bounds[pair.b];
    const double closing = closing_along(manifold.normal, bound_a, bound_b, walk.settings);
    margin = std::min(margin, margin_for(false, closing, walk.settings));
    drop_points_beyond(margin, manifold);
  }
  if (manifold.count == 0) return set_apart();
  const Sides sides = sides_of(walk.scene, pair);
  const Body &a = sides.a, &b = sides.b;
  const StartImpulses start = search.known ? start_impulses(manifold, walk.old[visit.old], walk.impulse_scale)
                              : search.given != nullptr ? start_impulses(manifold, *search.given, walk.sub_step)
                                                        : StartImpulses{};
  walk.old_next = visit.old + (search.known ? 1 : 0);
  Contact& contact = *place(walk);  // in place of the last step's contact, if there was one
  contact.key = pair.key;
  contact.slot_a = pair.a;
  contact.slot_b = pair.b;
  contact.b_fixed = with_fixed;
  contact.rolls_a = touches_on_side(a, sides.part_a, walk.scene.shapes.compounds, manifold);
  contact.rolls_b = touches_on_side(b, sides.part_b, walk.scene.shapes.compounds, manifold);
  contact.axis_cache = search.axis_cache;
  contact.friction = pair_friction(a, b);
  contact.may_be_flush = manifold.may_be_flush;
  contact.normal = manifold.normal;
  contact.count = manifold.count;
  for (std::uint32_t i = 0; i < manifold.count; ++i) {
    const ManifoldPoint& made = manifold.points[i];
    ContactPoint& point = contact.points[i];
    point.from_a = made.from_a;
    point.from_b = made.from_b;
    point.separation = made.separation;
    point.feature = made.feature;
    point.redundant = false;
    point.normal_impulse = start[i].normal;
    point.tangent_impulse[0] = start[i].tangent[0];
    point.tangent_impulse[1] = start[i].tangent[1];
    point.total_normal_impulse = 0.0;
    point.total_friction = {};
  }
  contact.round_a = round_at(sides.shape_a, contact.points[0].separation);
  contact.round_b = round_at(sides.shape_b, contact.points[0].separation);
  if (walk.written == 0 || &contact != &walk.contacts[walk.written - 1]) return;  // beyond the capacity
  ContactReference& reference = walk.references[walk.written - 1];
  reference.tolerance = 0.0;
  if (!(walk.settings.recycle_tolerance_m > 0.0) || !is_carried_over(sides.shape_a, sides.shape_b)) return;
  const auto& frame_b = with_fixed ? walk.scene.fixed_frames[pair.b] : walk.scene.frames[pair.b];
  reference = {.tolerance = tolerance_of(pair.key, sides.shape_a, sides.shape_b, walk.settings.recycle_tolerance_m),
               .margin = margin,
               .lever_arm = std::max(bounding_radius(a.shape), bounding_radius(b.shape))};
  store_anchors(contact, walk.scene.frames[pair.a], frame_b, reference);
}

// More contacts than capacity: keeps the deepest of contacts_ and beyond_, in the order of keys.
void ContactTable::keep_deepest(StepReport& report) noexcept {
  const std::uint32_t capacity = contacts_.capacity();
  report.capacity_bits |= kContactsFull;
  report.dropped += beyond_.size();
  const auto at = [&](std::uint32_t i) -> const Contact& {
    return i < capacity ? contacts_[i] : beyond_[i - capacity];
  };
  order_.resize(capacity + beyond_.size());
  for (std::uint32_t i = 0; i < order_.size(); ++i) order_[i] = i;
  // Ties by index, which is the order of keys.
  std::nth_element(order_.begin(), order_.begin() + capacity, order_.end(), [&](std::uint32_t i, std::uint32_t j) {
    const double s = at(i).least_separation(), t = at(j).least_separation();
    return s != t ? s < t : i < j;
  });
  order_.resize(capacity);
  std::sort(order_.begin(), order_.end());
  for (std::uint32_t i = 0; i < capacity; ++i) {  // order_[i] >= i: nothing is overwritten before it was read
    if (order_[i] == i) continue;
    contacts_[i] = at(order_[i]);
    references_[i] = order_[i] < capacity ? references_[order_[i]] : ContactReference{};
  }
}

void ContactTable::build(const Scene& scene, const StepSettings& settings, double sub_step, double impulse_scale,
                         StepReport& report, const Executor& executor) noexcept {
  sort_pairs();
  sort_warm_starts();
  if (pairs_dropped_ > 0) report.capacity_bits |= kPairsFull;
  report.dropped += pairs_dropped_;
  report.pairs = pairs_.size();

  Walk walk{.scene = scene,
            .settings = settings,
            .sub_step = sub_step,
            .impulse_scale = impulse_scale,
            .old = contacts_.begin(),
            .old_references = references_.begin(),
            .old_count = contacts_.size(),
            .contacts = contacts_.begin(),
            .references = references_.begin()};
  beyond_.clear();
  for (std::uint32_t next = 0; next < pairs_.size();) {
    walk.visits = walk.searches = 0;
    for (const std::uint32_t end = std::min(next + kStretch, pairs_.size()); next < end; ++next) visit(walk, next);
    executor.for_each_range(walk.searches, kMinSearches,
                            [&](std::uint32_t first, std::uint32_t end) noexcept { search(scene, first, end); });
    walk.searched += walk.searches;
    for (const Search& search : searches_.span().first(walk.searches))
      walk.comparisons += comparisons_in(scene, search);
    for (const Visit& visit : visits_.span().first(walk.visits)) {
      if (visit.search == kCarryOver)
        keep(walk, visit);
      else
        take_found(walk, visit, searches_[visit.search], manifolds_[visit.search]);
    }
  }
  if (walk.contacts != contacts_.begin()) {
    contacts_.swap(last_);
    references_.swap(last_references_);
  }
  contacts_.resize(walk.written);
  references_.resize(walk.written);
  if (!beyond_.empty()) keep_deepest(report);
  const TouchingBodies bodies{scene.bodies, scene.fixed_bodies, scene.shapes};
  if (!scene.shapes.compounds.empty()) mark_redundant_points(bodies, settings.slop, contacts_.span());
  seams_.mark(bodies, carry_over_margin(settings), contacts_.span());

  double smallest = 0.0;
  for (const Contact& contact : contacts_) {
    report.points += contact.count;
    for (std::uint32_t i = 0; i < contact.count; ++i) smallest = std::min(smallest, contact.points[i].separation);
  }
  report.contacts = contacts_.size();
  report.searched = walk.searched;
  report.comparisons = walk.comparisons;
  report.deepest_m = -smallest;
  warm_starts_.clear();
}

bool ContactTable::continue_contact(const WarmStart& given, double sub_step) noexcept {
  const Contact* found = find_contact(contacts(), given.key);
  if (found == nullptr) return add_warm_start(given);
  const auto at = static_cast<std::uint32_t>(found - contacts_.begin());
  if (found->axis_cache == given.axis_cache) {
    set_impulses(given, sub_step, contacts_[at]);
    return true;
  }
  std::copy(contacts_.begin() + at + 1, contacts_.end(), contacts_.begin() + at);
  std::copy(references_.begin() + at + 1, references_.end(), references_.begin() + at);
  contacts_.resize(contacts_.size() - 1);
  references_.resize(references_.size() - 1);
  return add_warm_start(given);
}

void ContactTable::scale_impulses_of(std::span<const std::uint8_t> bodies, double factor) noexcept {
  for (Contact& contact : contacts_)
    for (std::uint32_t i = 0; i < contact.count && bodies[contact.slot_a] != 0; ++i)
      scale_impulses(contact.points[i], factor);
}

void ContactTable::slot_inserted(std::uint32_t slot, bool fixed) noexcept {
  if (fixed) pairs_.clear();  // known gaps may be those of a removed body with the same id
  for (Contact& contact : contacts_) {
    if (!fixed && contact.slot_a >= slot) ++contact.slot_a;
    if (contact.b_fixed == fixed && contact.slot_b >= slot) ++contact.slot_b;
  }
}

void ContactTable::slot_removed(std::uint32_t slot, bool fixed) noexcept {
  std::uint32_t kept = 0;
  for (std::uint32_t i = 0; i < contacts_.size(); ++i) {
    Contact& contact = contacts_[i];
    const bool b_in_question = contact.b_fixed == fixed;
    if ((!fixed && contact.slot_a == slot) || (b_in_question && contact.slot_b == slot)) continue;
    if (!fixed && contact.slot_a > slot) --contact.slot_a;
    if (b_in_question && contact.slot_b > slot) --contact.slot_b;
    if (kept != i) {
      contacts_[kept] = contact;
      references_[kept] = references_[i];
    }
    ++kept;
  }
  contacts_.resize(kept);
  references_.resize(kept);
}

void ContactTable::slots_moved(std::span<const std::uint32_t> to) noexcept {
  std::uint32_t kept = 0;
  for (std::uint32_t i = 0; i < contacts_.size(); ++i) {
    Contact& contact = contacts_[i];
    const std::uint32_t a = to[contact.slot_a], b = contact.b_fixed ? contact.slot_b : to[contact.slot_b];
    if (a == kNoSlot || b == kNoSlot) continue;
    contact.slot_a = a;
    contact.slot_b = b;
    if (kept != i) {
      contacts_[kept] = contact;
      references_[kept] = references_[i];
    }
    ++kept;
  }
  contacts_.resize(kept);
  references_.resize(kept);
}

}  // namespace tactus::physics
