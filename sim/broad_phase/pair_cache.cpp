#include "sim/broad_phase/pair_cache.h"

#include <algorithm>

namespace tactus::sim {
namespace {

using physics::Aabb;
using physics::SlotPair;

// Margin of a fat box over the body's least extent. A larger one: fewer bodies leave their fat box, and more kept pairs
// do not overlap.
constexpr double kRoom = 1.0 / 16;
// If more than one body in kFewMoved left its fat box, updating them one by one costs more than a rebuild.
constexpr std::size_t kFewMoved = 8;
// Steps without fat boxes after they were of no use.
constexpr std::uint32_t kPause = 8;

Aabb room_for(const Aabb& box) noexcept {
  const Vec3d extent = box.upper - box.lower;
  const double more = kRoom * std::min(extent.x, std::min(extent.y, extent.z));
  const Vec3d grown{more, more, more};
  return {box.lower - grown, box.upper + grown};
}

bool comes_before(const SlotPair& p, const SlotPair& q) noexcept { return p.a != q.a ? p.a < q.a : p.b < q.b; }

}  // namespace

PairCache::PairCache(std::uint32_t max_bodies, std::uint32_t max_pairs)
    : grid_(max_bodies),
      rooms_in_space_(max_bodies),
      order_(max_bodies, max_pairs),
      room_(max_bodies),
      has_moved_(max_bodies),
      kept_(max_pairs),
      found_(max_pairs) {
  moved_.reserve(max_bodies);
}

void PairCache::share_work(const physics::Executor& executor, std::uint32_t parts) {
  grid_.share_work(executor, parts, kept_.capacity());
}

bool PairCache::find(std::span<const Aabb> bounds, BoundedVector<SlotPair>& pairs) noexcept {
  TACTUS_CHECK(bounds.size() <= room_.size(), bounds.size(), room_.size());
  holds_ = holds_ && bounds.size() == count_;
  if (holds_) {
    note_moved(bounds);
    const bool few = moved_.size() * kFewMoved <= bounds.size();
    if (!few && age_ == 0) pause_ = kPause;
    holds_ = few && refresh(bounds);
    ++age_;
  }
  if (!holds_ && pause_ == 0) {
    holds_ = rebuild(bounds);
    if (!holds_) pause_ = kPause;
  }
  if (!holds_) {
    if (pause_ > 0) --pause_;
    ++work_.direct;
    return grid_.find(bounds, pairs);
  }
  for (const SlotPair& pair : kept_)
    if (bounds[pair.a].overlaps(bounds[pair.b]) && !pairs.try_push(pair)) return false;
  return true;
}

void PairCache::note_moved(std::span<const Aabb> bounds) noexcept {
  moved_.clear();
  for (std::uint32_t body = 0; body < bounds.size(); ++body) {
    const bool moved = !room_[body].holds(bounds[body]);
    has_moved_[body] = moved ? 1 : 0;
    if (moved) moved_.push_back(body);
  }
}

bool PairCache::rebuild(std::span<const Aabb> bounds) noexcept {
  count_ = static_cast<std::uint32_t>(bounds.size());
  for (std::uint32_t body = 0; body < count_; ++body) room_[body] = room_for(bounds[body]);
  kept_.clear();
  in_space_ = false;
  age_ = 0;
  if (!grid_.find(std::span<const Aabb>(room_).first(count_), kept_)) return false;
  order_.sort(kept_, count_);
  ++work_.rebuilt;
  return true;
}

bool PairCache::refresh(std::span<const Aabb> bounds) noexcept {
  ++work_.kept;
  if (moved_.empty()) return true;
  work_.moved += moved_.size();
  if (!in_space_) {
    rooms_in_space_.clear();
    for (std::uint32_t body = 0; body < count_; ++body) rooms_in_space_.insert(body, room_[body]);
    in_space_ = true;
  }
  for (const std::uint32_t body : moved_) {
    room_[body] = room_for(bounds[body]);
    rooms_in_space_.remove(body);
    rooms_in_space_.insert(body, room_[body]);
  }
  return find_pairs_of_moved() && merge_found();
}

bool PairCache::find_pairs_of_moved() noexcept {
  found_.clear();
  bool all = true;
  for (const std::uint32_t body : moved_)
    rooms_in_space_.find(room_[body], [&](std::uint32_t other) noexcept {
      // If both bodies moved, the lower one adds the pair.
      if (other == body || (has_moved_[other] != 0 && other < body)) return;
      all = found_.try_push({std::min(body, other), std::max(body, other)}) && all;
    });
  return all;
}

// Removes the kept pairs of bodies that moved and merges in the pairs found for these, in order.
bool PairCache::merge_found() noexcept {
  std::uint32_t stayed = 0;
  for (std::uint32_t i = 0; i < kept_.size(); ++i) {
    const SlotPair pair = kept_[i];
    if ((has_moved_[pair.a] | has_moved_[pair.b]) == 0) kept_[stayed++] = pair;
  }
  if (stayed + found_.size() > kept_.capacity()) return false;
  std::sort(found_.begin(), found_.end(), comes_before);
  kept_.resize(stayed + found_.size());
  // Merges from the back, so that nothing is overwritten before it is read.
  std::uint32_t from_kept = stayed, from_found = found_.size();
  for (std::uint32_t to = kept_.size(); from_found > 0; --to) {
    const bool keeps = from_kept > 0 && comes_before(found_[from_found - 1], kept_[from_kept - 1]);
    kept_[to - 1] = keeps ? kept_[--from_kept] : found_[--from_found];
  }
  return true;
}

}  // namespace tactus::sim
