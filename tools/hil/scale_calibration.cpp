#include "tools/hil/scale_calibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace tactus::hil {
namespace {

constexpr double kLeastReading_g = -100, kMostReading_g = 5000;
// A scale shows whole grams: less than ten of them for a push say too little.
constexpr double kLeastShown_N = 0.1;
constexpr double kMostSpread = 0.05, kMostOffset_N = 0.3, kMostDrift_N = 0.1;

double grams(double force_N) { return force_N / ScaleCalibration::kWeight_N_per_g; }

}  // namespace

std::optional<double> parse_grams(const std::string& text) {
  std::string number = text;
  std::erase_if(number, [](char c) { return c == ' ' || c == '\t' || c == '\r'; });
  if (!number.empty() && number.back() == 'g') number.pop_back();
  std::replace(number.begin(), number.end(), ',', '.');
  double value = 0;
  const char* const last = number.data() + number.size();
  const auto [end, error] = std::from_chars(number.data(), last, value);
  const bool whole = error == std::errc() && end == last;
  if (!whole || !(value >= kLeastReading_g && value <= kMostReading_g)) return std::nullopt;
  return value;
}

double ScaleCalibration::next_command_N() const noexcept {
  const double wanted_N = kPushes_N[points_.size()];
  if (points_.empty()) return wanted_N;
  return std::min(peak_N_, wanted_N * points_.back().commanded_N / points_.back().measured_N);
}

std::string ScaleCalibration::doubt_of(double gain_per_Nm, double share) {
  if (gain_per_Nm >= kLeastGain / share && gain_per_Nm <= kMostGain * share) return {};
  return fmt::format(
      "the gain would be {:.0f}, and others have 2300 to 10000: see that the grip alone rests on the scale",
      gain_per_Nm);
}

std::string ScaleCalibration::take(double measured_N) {
  const double commanded_N = next_command_N();
  // A first push that gave more than was wanted is followed by a smaller one.
  const bool more = points_.empty() || commanded_N > points_.back().commanded_N;
  const double before_N = points_.empty() ? 0 : points_.back().measured_N;
  if (measured_N < kLeastShown_N || (measured_N > before_N) != more)
    return fmt::format(
        "the scale shows {:.0f} g for {:.2f} N, after {:.0f} g: the grip does not rest on it, or friction holds it",
        grams(measured_N), commanded_N, grams(before_N));
  points_.push_back({commanded_N, measured_N});
  return doubt_of(used_per_Nm_ * commanded_N / measured_N, 2);
}

GainResult ScaleCalibration::result(double drift_N) const {
  double mean_commanded = 0, mean_measured = 0, both = 0, square = 0, largest_N = 0;
  const auto count = static_cast<double>(points_.size());
  for (const Point& p : points_) {
    mean_commanded += p.commanded_N / count;
    mean_measured += p.measured_N / count;
    largest_N = std::max(largest_N, p.measured_N);
  }
  for (const Point& p : points_) {
    both += (p.commanded_N - mean_commanded) * (p.measured_N - mean_measured);
    square += (p.commanded_N - mean_commanded) * (p.commanded_N - mean_commanded);
  }
  const double slope = both / square;
  GainResult result{
      .gain_per_Nm = used_per_Nm_ / slope, .offset_N = mean_measured - slope * mean_commanded, .doubt = {}};
  for (const Point& p : points_)
    result.spread =
        std::max(result.spread, std::abs(p.measured_N - result.offset_N - slope * p.commanded_N) / largest_N);
  if (result.spread > kMostSpread)
    result.doubt = fmt::format("the readings lie {:.0f} % off a line: one of them is wrong, or the grip moved",
                               100 * result.spread);
  else if (std::abs(result.offset_N) > kMostOffset_N)
    result.doubt = fmt::format("the line misses zero by {:.0f} g: friction is large, or the scale was not read at rest",
                               grams(result.offset_N));
  else if (std::abs(drift_N) > kMostDrift_N)
    result.doubt =
        fmt::format("without force the scale shows {:.0f} g more than before: the grip moved", grams(drift_N));
  else
    result.doubt = doubt_of(result.gain_per_Nm, 1);
  return result;
}

}  // namespace tactus::hil
