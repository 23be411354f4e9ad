#include "sim/broad_phase/pair_cache.h"

#include <algorithm>

namespace tactus::sim {
namespace {

using physics::Aabb;
using physics::SlotPair;

// Margin of a fat box, as a share of the body's least extent. A larger one: fewer bodies leave their fat box, and more
// kept pairs do not overlap.
constexpr double kMarginShare = 1.0 / 16;
// If more than one body in kFewMoved left its fat box, updating them one by one costs more than a rebuild.
constexpr std::size_t kFewMoved = 8;
// Steps without fat boxes after they were of no use.
constexpr std::uint32_t kPause = 8;

Aabb fat_box_of(const Aabb& box) noexcept {
  const Vec3d extent = box.upper - box.lower;
  const double more = kMarginShare * std::min(extent.x, std::min(extent.y, extent.z));
  const Vec3d grown{more, more, more};
  return {box.lower - grown, box.upper + grown};
}

bool comes_before(const SlotPair& p, const SlotPair& q) noexcept { return p.a != q.a ? p.a < q.a : p.b < q.b; }

}  // namespace

PairCache::PairCache(std::uint32_t max_bodies, std::uint32_t max_pairs)
    : grid_(max_bodies),
      fat_box_grid_(max_bodies),
      order_(max_bodies, max_pairs),
      fat_boxes_(max_bodies),
      has_moved_(max_bodies),
      kept_(max_pairs),
      found_(max_pairs) {
  moved_.reserve(max_bodies);
}

void PairCache::share_work(const physics::Executor& executor, std::uint32_t parts) {
  grid_.share_work(executor, parts, kept_.capacity());
}

bool PairCache::find(std::span<const Aabb> bounds, BoundedVector<SlotPair>& pairs) noexcept {
  TACTUS_CHECK(bounds.size() <= fat_boxes_.size(), bounds.size(), fat_boxes_.size());
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
    const bool moved = !fat_boxes_[body].holds(bounds[body]);
    has_moved_[body] = moved ? 1 : 0;
    if (moved) moved_.push_back(body);
  }
}

bool PairCache::rebuild(std::span<const Aabb> bounds) noexcept {
  count_ = static_cast<std::uint32_t>(bounds.size());
  for (std::uint32_t body = 0; body < count_; ++body) fat_boxes_[body] = fat_box_of(bounds[body]);
  kept_.clear();
  in_space_ = false;
  age_ = 0;
  if (!grid_.find(std::span<const Aabb>(fat_boxes_).first(count_), kept_)) return false;
  order_.sort(kept_, count_);
  ++work_.rebuilt;
  return true;
}

bool PairCache::refresh(std::span<const Aabb> bounds) noexcept {
  ++work_.kept;
  if (moved_.empty()) return true;
  work_.moved += moved_.size();
  if (!in_space_) {
    fat_box_grid_.clear();
    for (std::uint32_t body = 0; body < count_; ++body) fat_box_grid_.insert(body, fat_boxes_[body]);
    in_space_ = true;
  }
  for (const std::uint32_t body : moved_) {
    fat_boxes_[body] = fat_box_of(bounds[body]);
    fat_box_grid_.remove(body);
    fat_box_grid_.insert(body, fat_boxes_[body]);
  }
  return find_pairs_of_moved() && merge_found();
}

bool PairCache::find_pairs_of_moved() noexcept {
  found_.clear();
  bool all = true;
  for (const std::uint32_t body : moved_)
    fat_box_grid_.find(fat_boxes_[body], [&](std::uint32_t other) noexcept {
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
