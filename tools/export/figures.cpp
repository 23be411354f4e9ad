#include "tools/export/figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

namespace tactus::exporting {
namespace {

constexpr std::pair<std::string_view, Figure::How> kWords[] = {{"mean", Figure::How::kMean},
                                                               {"rms", Figure::How::kRms},
                                                               {"min", Figure::How::kMin},
                                                               {"max", Figure::How::kMax},
                                                               {"last", Figure::How::kLast}};

// p0 to p100.
bool read_percentile(std::string_view word, double& percent) {
  if (!word.starts_with('p')) return false;
  const char* const end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data() + 1, end, percent, std::chars_format::fixed);
  return error == std::errc() && stop == end && percent >= 0 && percent <= 100;
}

bool read_how(std::string_view word, Figure& figure) {
  const auto* known = std::ranges::find(kWords, word, &std::pair<std::string_view, Figure::How>::first);
  if (known != std::end(kWords)) {
    figure.how = known->second;
    return true;
  }
  figure.how = Figure::How::kPercentile;
  return read_percentile(word, figure.percent);
}

double percentile(std::vector<double> values, double percent) {
  const auto count = static_cast<double>(values.size());
  const auto rank = static_cast<std::ptrdiff_t>(std::ceil(percent / 100 * count));
  const auto at = values.begin() + std::max<std::ptrdiff_t>(rank - 1, 0);
  std::ranges::nth_element(values, at);
  return *at;
}

}  // namespace

Result<std::vector<Figure>> parse_figures(std::span<const std::string> words) {
  std::vector<Figure> figures;
  for (const std::string& word : words) {
    const std::size_t colon = word.find(':');
    Figure figure;
    figure.name = word;
    if (colon == std::string::npos || !read_how(std::string_view(word).substr(colon + 1), figure))
      return Status::error(
          fmt::format("'{:.64}' is no figure; accepted: COLUMN:HOW, with mean, rms, min, max, last or p0 "
                      "to p100, such as force_z_N:p99",
                      word));
    const std::string column = word.substr(0, colon);
    const auto& all = all_columns();
    const auto found = std::ranges::find(all, column, &Column::name);
    if (found == all.end()) {
      const auto chosen = select_columns(std::span<const std::string>(&column, 1));  // its message has the nearest
      return Status::error(chosen.ok() ? fmt::format("'{}' is a group; accepted: one of its columns", column)
                                       : chosen.message());
    }
    figure.column = *found;
    figures.push_back(std::move(figure));
  }
  return figures;
}

Figures::Figures(std::vector<Figure> figures, double period_s)
    : figures_(std::move(figures)), sums_(figures_.size()), period_s_(period_s) {}

void Figures::take(const loop::TickRecord& tick) {
  const Row row{tick, {}};
  for (std::size_t i = 0; i < figures_.size(); ++i) {
    const Column& column = figures_[i].column;
    const Value value = value_of(column, row, period_s_);
    const double number = column.is_real() ? value.real : static_cast<double>(value.count);
    Sums& sums = sums_[i];
    sums.sum += number;
    sums.squares += number * number;
    sums.min = ticks_ == 0 ? number : std::min(sums.min, number);
    sums.max = ticks_ == 0 ? number : std::max(sums.max, number);
    sums.last = number;
    if (figures_[i].how == Figure::How::kPercentile) sums.all.push_back(number);
  }
  ++ticks_;
}

std::vector<std::pair<std::string, double>> Figures::values() const {
  const auto count = static_cast<double>(ticks_);
  const auto value = [&](const Figure& figure, const Sums& sums) {
    switch (figure.how) {
      case Figure::How::kMean:
        return sums.sum / count;
      case Figure::How::kRms:
        return std::sqrt(sums.squares / count);
      case Figure::How::kMin:
        return sums.min;
      case Figure::How::kMax:
        return sums.max;
      case Figure::How::kLast:
        return sums.last;
      case Figure::How::kPercentile:
        return percentile(sums.all, figure.percent);
    }
    return 0.0;
  };
  std::vector<std::pair<std::string, double>> values;
  for (std::size_t i = 0; i < figures_.size(); ++i)
    values.emplace_back(figures_[i].name,
                        ticks_ == 0 ? std::numeric_limits<double>::quiet_NaN() : value(figures_[i], sums_[i]));
  return values;
}

}  // namespace tactus::exporting
