#include "tools/timing/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/plot/svg.h"

namespace tactus::timing {
namespace {

constexpr int kBarWidth = 24;

// How many times are in (low, high].
std::uint64_t count_between(const Histogram& h, std::uint64_t low_ns, std::uint64_t high_ns) {
  std::uint64_t count = 0;
  for (std::uint32_t i = Histogram::bucket_of(low_ns) + (low_ns > 0 ? 1 : 0); i <= Histogram::bucket_of(high_ns); ++i)
    count += h.in_bucket(i);
  return count;
}

// One tick is one block; the largest count is the full width.
std::string bar(std::uint64_t count, std::uint64_t most) {
  if (count == 0) return "";
  const double share = most > 1 ? std::log(static_cast<double>(count)) / std::log(static_cast<double>(most)) : 1;
  std::string text;
  for (int i = 0; i < 1 + static_cast<int>(share * (kBarWidth - 1) + 0.5); ++i) text += "\u2588";
  return text;
}

int width_of(std::uint64_t count, std::uint64_t most) { return static_cast<int>(bar(count, most).size() / 3); }

std::string time_text(double us) { return us < 1000 ? fmt::format("{:g} us", us) : fmt::format("{:g} ms", us / 1000); }

}  // namespace

std::string histogram_text(const std::vector<Curve>& curves, std::int64_t mark_ns) {
  std::vector<double> edges_us{0};
  for (double decade = 1; decade < 1e7; decade *= 10)
    for (const double step : {1.0, 2.0, 5.0}) edges_us.push_back(decade * step);
  std::vector<std::vector<std::uint64_t>> counts;
  std::uint64_t most = 1;
  std::size_t first = edges_us.size(), last = 0;
  for (const Curve& curve : curves) {
    auto& column = counts.emplace_back();
    for (std::size_t i = 0; i + 1 < edges_us.size(); ++i) {
      column.push_back(count_between(*curve.times, static_cast<std::uint64_t>(edges_us[i] * 1e3),
                                     static_cast<std::uint64_t>(edges_us[i + 1] * 1e3)));
      if (column.back() == 0) continue;
      most = std::max(most, column.back());
      first = std::min(first, i);
      last = std::max(last, i);
    }
  }
  std::string text = fmt::format("{:>12}", "");
  for (const Curve& curve : curves) text += fmt::format("  {:<{}}", curve.name, kBarWidth + 10);
  text += "\n";
  for (std::size_t i = first; i <= last && i + 1 < edges_us.size(); ++i) {
    const bool deadline =
        edges_us[i] * 1e3 <= static_cast<double>(mark_ns) && edges_us[i + 1] * 1e3 > static_cast<double>(mark_ns);
    if (deadline)
      text += fmt::format("{:-<{}}  deadline, {}\n", "", 12 + curves.size() * (kBarWidth + 12),
                          time_text(static_cast<double>(mark_ns) * 1e-3));
    text += fmt::format("{:>12}", "<= " + time_text(edges_us[i + 1]));
    for (const auto& column : counts)
      text += fmt::format("  {}{:<{}}{:>10}", bar(column[i], most), "", kBarWidth - width_of(column[i], most),
                          column[i] > 0 ? fmt::format("{}", column[i]) : "");
    text += "\n";
  }
  return text;
}

namespace {

// Layout, px. Narrow, so that text is still readable in a window of 400 px. On the right, the last tick's label reaches
// half its width beyond the axis: up to six digits ("100000") of 8 px.
constexpr double kWidth = 560, kLeft = 96, kRight = 30, kPlotHeight = 300, kLine = 16;
constexpr std::size_t kWordsBold = 68, kWords = 84;  // characters that fit a line of the sentence, of the rest

// From the start of the first curve to beyond the last curve and the deadline, in whole decades of us.
plot::LogAxis time_axis(const std::vector<Curve>& curves, double mark_us) {
  double shortest_us = mark_us, longest_us = 2 * mark_us;
  for (const Curve& curve : curves) {
    if (curve.times->count() == 0) continue;
    longest_us = std::max(longest_us, static_cast<double>(curve.times->max_ns()) * 1e-3);
    std::uint32_t first = 0;
    while (first + 1 < Histogram::kBuckets && curve.times->in_bucket(first) == 0) ++first;
    shortest_us = std::min(shortest_us, static_cast<double>(Histogram::upper_bound_ns(first)) * 1e-3);
  }
  const double low = std::floor(std::log10(std::max(shortest_us, 0.01)) + 1e-9);
  return {.low = low,
          .high = std::max(low + 1, std::ceil(std::log10(longest_us))),
          .start = kLeft,
          .end = kWidth - kRight,
          .label = "time [\u00b5s]",
          .threes = true};
}

// From all ticks at the top to one tick of `ticks`.
plot::LogAxis share_axis(std::uint64_t ticks, double top) {
  return {.low = 0,
          .high = std::ceil(std::log10(static_cast<double>(ticks)) - 1e-9),
          .start = top,
          .end = top + kPlotHeight,
          .label = "ticks that took longer [1 in N]",
          .tick_text = [](double n) { return n == 1 ? "all" : "1 in " + plot::number_text(n); }};
}

// The share of the ticks that took longer, as steps.
std::vector<plot::Point> falling(const Histogram& times, const plot::LogAxis& x, const plot::LogAxis& y) {
  const double all = static_cast<double>(times.count());
  std::uint64_t above = times.count();
  std::vector<plot::Point> points{{x.start, y.at(1)}};
  for (std::uint32_t i = 0; i < Histogram::kBuckets && above > 0; ++i) {
    if (times.in_bucket(i) == 0) continue;
    const double at_x = x.at(static_cast<double>(Histogram::upper_bound_ns(i)) * 1e-3);
    points.push_back({at_x, y.at(all / static_cast<double>(above))});
    above -= times.in_bucket(i);
    if (above > 0) points.push_back({at_x, y.at(all / static_cast<double>(above))});
  }
  return points;
}

// Draws the legend; returns its lower end.
double draw_key(plot::Drawing& drawing, const std::vector<const Curve*>& drawn, double mark_us, double top) {
  const auto entry = [&](const std::string& kind, const std::string& words) {
    drawing.line(kind, {8, top - 4}, {48, top - 4});
    drawing.text("key", {56, top}, plot::Anchor::kStart, words);
    top += kLine;
  };
  for (std::size_t i = 0; i < drawn.size(); ++i) entry(fmt::format("series s{}", i), drawn[i]->name);
  entry("limit", "deadline, " + time_text(mark_us));
  return top;
}

}  // namespace

std::string histogram_svg(const std::string& sentence, const Provenance& made, const std::vector<Curve>& curves,
                          std::int64_t mark_ns) {
  plot::Drawing drawing;
  double top = drawing.paragraph("answer", {8, 24}, sentence, kWordsBold) + 3;
  for (const std::string& words :
       {fmt::format("date: {}; version: {}, built for {}", made.date_utc, made.version, made.built_for),
        "machine: " + made.machine, "command: " + made.command})
    top = drawing.paragraph("made", {8, top}, words, kWords) + 3;
  std::vector<const Curve*> drawn;
  std::uint64_t most = 10;
  for (const Curve& curve : curves)
    if (curve.times->count() > 0) {
      drawn.push_back(&curve);
      most = std::max(most, curve.times->count());
    }
  const double mark_us = static_cast<double>(mark_ns) * 1e-3;
  top = draw_key(drawing, drawn, mark_us, top + 10) + 34;
  const plot::LogAxis x = time_axis(curves, mark_us), y = share_axis(most, top);
  drawing.axes(x, y);
  for (std::size_t i = 0; i < drawn.size(); ++i) drawing.curve(i, drawn[i]->name, falling(*drawn[i]->times, x, y));
  drawing.line("limit", {x.at(mark_us), y.start}, {x.at(mark_us), y.end});
  return drawing.svg(sentence, {kWidth, y.end + 52});
}

}  // namespace tactus::timing
