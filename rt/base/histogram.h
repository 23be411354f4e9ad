// A histogram of times in nanoseconds of fixed size: exact below 128 ns, above with a relative error below 1/64 (1.6
// %), up to 2^34 ns (17 s).
//
// Each power of two is divided into 64 equal buckets, so the bucket of a value is given by its top seven bits. Thread:
// [rt] record; everything else [any], by the owner of the copy: it is trivially copyable and crosses threads by value.
// Bound: a longer time is recorded in the last bucket and counted as clipped; count, sum, min and max stay exact.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <type_traits>

namespace tactus {

class Histogram {
 public:
  static constexpr int kTopBit = 34;  // first power of two beyond the range
  static constexpr std::uint64_t kRange_ns = 1ull << kTopBit;
  static constexpr std::uint32_t kLinear = 128, kPerOctave = 64;  // exact buckets; buckets in each octave above
  static constexpr std::uint32_t kBuckets = kLinear + kPerOctave * static_cast<std::uint32_t>(kTopBit - 7);

  // A negative time (an early wake-up) counts as 0.
  void record(std::int64_t time_ns) noexcept {
    const std::uint64_t value = time_ns > 0 ? static_cast<std::uint64_t>(time_ns) : 0;
    ++buckets_[bucket_of(value)];
    ++count_;
    sum_ns_ += value;
    min_ns_ = std::min(min_ns_, value);
    max_ns_ = std::max(max_ns_, value);
    if (value >= kRange_ns) ++clipped_;
  }

  void merge(const Histogram& other) noexcept {
    for (std::uint32_t i = 0; i < kBuckets; ++i) buckets_[i] += other.buckets_[i];
    count_ += other.count_;
    sum_ns_ += other.sum_ns_;
    min_ns_ = std::min(min_ns_, other.min_ns_);
    max_ns_ = std::max(max_ns_, other.max_ns_);
    clipped_ += other.clipped_;
  }

  std::uint64_t count() const noexcept { return count_; }
  std::uint64_t clipped() const noexcept { return clipped_; }
  std::uint64_t min_ns() const noexcept { return count_ == 0 ? 0 : min_ns_; }
  std::uint64_t max_ns() const noexcept { return max_ns_; }
  double mean_ns() const noexcept {
    return count_ == 0 ? 0.0 : static_cast<double>(sum_ns_) / static_cast<double>(count_);
  }

  // The time that at least `percent` of the recorded times do not exceed: the upper bound of its bucket, at most the
  // maximum. 0 if empty.
  std::uint64_t percentile_ns(double percent) const noexcept {
    if (count_ == 0) return 0;
    // Without the small margin 99.99 % of 10 000 could round up to the 10 000th.
    const double rank = std::ceil(std::clamp(percent, 0.0, 100.0) * 0.01 * static_cast<double>(count_) - 1e-6);
    std::uint64_t below = 0;
    for (std::uint32_t i = 0; i + 1 < kBuckets; ++i) {
      below += buckets_[i];
      if (below > 0 && static_cast<double>(below) >= rank) return std::min(upper_bound_ns(i), max_ns_);
    }
    return max_ns_;
  }

  // Number of times in [lower, upper] of bucket i, for exports.
  std::uint64_t in_bucket(std::uint32_t i) const noexcept { return buckets_[i]; }
  static constexpr std::uint64_t lower_bound_ns(std::uint32_t i) noexcept {
    if (i < kLinear) return i;
    const std::uint32_t octave = (i - kLinear) / kPerOctave, part = (i - kLinear) % kPerOctave;
    return static_cast<std::uint64_t>(kPerOctave + part) << (octave + 1);
  }
  static constexpr std::uint64_t upper_bound_ns(std::uint32_t i) noexcept { return lower_bound_ns(i + 1) - 1; }
  static constexpr std::uint32_t bucket_of(std::uint64_t value_ns) noexcept {
    if (value_ns < kLinear) return static_cast<std::uint32_t>(value_ns);
    if (value_ns >= kRange_ns) return kBuckets - 1;
    const auto octave = static_cast<std::uint32_t>(std::bit_width(value_ns)) - 8;  // 0 for 128..255
    return kLinear + octave * kPerOctave + static_cast<std::uint32_t>(value_ns >> (octave + 1)) - kPerOctave;
  }

 private:
  std::array<std::uint64_t, kBuckets> buckets_{};
  std::uint64_t count_{0}, sum_ns_{0}, min_ns_{~0ull}, max_ns_{0}, clipped_{0};
};

static_assert(std::is_trivially_copyable_v<Histogram>);

}  // namespace tactus
