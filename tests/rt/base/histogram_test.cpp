#include "rt/base/histogram.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>
#include <vector>

using namespace tactus;

namespace {

// Times over the whole range: uniform in the logarithm.
std::vector<std::uint64_t> some_times(std::uint32_t seed, std::size_t count) {
  std::mt19937_64 random(seed);
  std::vector<std::uint64_t> times(count);
  for (auto& t : times) t = random() >> (64 - Histogram::kTopBit) >> (random() % Histogram::kTopBit);
  return times;
}

}  // namespace

TEST_CASE("the buckets cover the range without gap or overlap", "[base]") {
  CHECK(Histogram::lower_bound_ns(0) == 0);
  for (std::uint32_t i = 0; i < Histogram::kBuckets; ++i) {
    REQUIRE(Histogram::bucket_of(Histogram::lower_bound_ns(i)) == i);
    REQUIRE(Histogram::bucket_of(Histogram::upper_bound_ns(i)) == i);
  }
  CHECK(Histogram::upper_bound_ns(Histogram::kBuckets - 1) == Histogram::kRange_ns - 1);
}

TEST_CASE("a bucket is exact below 128 ns and narrower than a sixty-fourth of its times above", "[base]") {
  for (const std::uint64_t t : some_times(1, 100'000)) {
    const std::uint32_t i = Histogram::bucket_of(t);
    REQUIRE(Histogram::lower_bound_ns(i) <= t);
    REQUIRE(t <= Histogram::upper_bound_ns(i));
    if (t < 128) REQUIRE(Histogram::upper_bound_ns(i) == t);
    REQUIRE((Histogram::upper_bound_ns(i) - t) * 64 <= t);
  }
}

TEST_CASE("a percentile bounds the sorted sample's from above, by less than 1.6 %", "[base]") {
  for (std::uint32_t seed = 0; seed < 20; ++seed) {
    auto times = some_times(seed, 1 + seed * 97);
    Histogram histogram;
    for (const auto t : times) histogram.record(static_cast<std::int64_t>(t));
    std::sort(times.begin(), times.end());
    for (const double percent : {0.0, 1.0, 25.0, 50.0, 90.0, 99.0, 99.9, 100.0}) {
      // Per mille in whole numbers, so that the rank here has no rounding of its own.
      const auto per_mille = static_cast<std::size_t>(percent * 10 + 0.5);
      const std::size_t rank = std::max<std::size_t>(1, (per_mille * times.size() + 999) / 1000);
      const std::uint64_t exact = times[rank - 1], got = histogram.percentile_ns(percent);
      INFO("seed " << seed << ", " << percent << " %: " << got << " for " << exact);
      CHECK(got >= exact);
      CHECK((got - exact) * 64 <= exact);
    }
    CHECK(histogram.percentile_ns(100) == times.back());
  }
}

TEST_CASE("the 99.99th percentile of ten thousand leaves one above", "[base]") {
  Histogram histogram;
  for (int i = 0; i < 9999; ++i) histogram.record(10);
  histogram.record(100);
  CHECK(histogram.percentile_ns(99.99) == 10);
  CHECK(histogram.percentile_ns(99.995) == 100);
}

TEST_CASE("count, minimum, maximum and mean are exact, beyond the range as well", "[base]") {
  Histogram histogram;
  CHECK(histogram.count() == 0);
  CHECK(histogram.min_ns() == 0);
  CHECK(histogram.max_ns() == 0);
  CHECK(histogram.mean_ns() == 0.0);
  CHECK(histogram.percentile_ns(50) == 0);
  const auto far = static_cast<std::int64_t>(Histogram::kRange_ns * 3);
  histogram.record(1000);
  histogram.record(far);
  histogram.record(-5);
  CHECK(histogram.count() == 3);
  CHECK(histogram.clipped() == 1);
  CHECK(histogram.min_ns() == 0);
  CHECK(histogram.max_ns() == static_cast<std::uint64_t>(far));
  CHECK(histogram.mean_ns() == static_cast<double>(far + 1000) / 3.0);
  CHECK(histogram.percentile_ns(100) == static_cast<std::uint64_t>(far));
}

TEST_CASE("merging two histograms is recording both samples into one", "[base]") {
  Histogram a, b, both;
  for (const auto t : some_times(7, 3000)) {
    a.record(static_cast<std::int64_t>(t));
    both.record(static_cast<std::int64_t>(t));
  }
  for (const auto t : some_times(8, 2000)) {
    b.record(static_cast<std::int64_t>(t));
    both.record(static_cast<std::int64_t>(t));
  }
  b.record(1ll << 40);
  both.record(1ll << 40);
  a.merge(b);
  for (std::uint32_t i = 0; i < Histogram::kBuckets; ++i) REQUIRE(a.in_bucket(i) == both.in_bucket(i));
  CHECK(a.count() == both.count());
  CHECK(a.min_ns() == both.min_ns());
  CHECK(a.max_ns() == both.max_ns());
  CHECK(a.mean_ns() == both.mean_ns());
  CHECK(a.clipped() == both.clipped());
  Histogram empty;
  empty.merge(a);
  CHECK(empty.min_ns() == a.min_ns());
}
