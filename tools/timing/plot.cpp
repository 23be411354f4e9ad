#include "tools/timing/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

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

// One tick is a block; the most there are is the full width.
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
      first = std::min(first, i), last = std::max(last, i);
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

std::string histogram_svg(const std::string& title, const std::vector<Curve>& curves, std::int64_t mark_ns) {
  constexpr double kWidth = 760, kHeight = 440, kLeft = 70, kRight = 20, kTop = 40, kBottom = 50;
  std::uint64_t most = 10;
  double longest_us = static_cast<double>(mark_ns) * 2e-3;
  for (const Curve& curve : curves) {
    most = std::max(most, curve.times->count());
    longest_us = std::max(longest_us, static_cast<double>(curve.times->max_ns()) * 1e-3);
  }
  const double low = 0, high = std::ceil(std::log10(longest_us)),
               deep = std::ceil(std::log10(static_cast<double>(most)));
  const auto x = [&](double us) {
    return kLeft + (std::log10(std::max(us, 1.0)) - low) / (high - low) * (kWidth - kLeft - kRight);
  };
  const auto y = [&](double share) { return kTop - std::log10(share) / deep * (kHeight - kTop - kBottom); };
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" font-family=\"sans-serif\" "
      "font-size=\"12\">\n<rect width=\"{0}\" height=\"{1}\" fill=\"white\"/>\n"
      "<text x=\"{2}\" y=\"18\" font-size=\"14\">{3}</text>\n",
      kWidth, kHeight, kLeft, title);
  const auto line = [&](double x1, double y1, double x2, double y2, const char* colour) {
    svg += fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"{}\"/>\n", x1, y1, x2,
                       y2, colour);
  };
  const auto label = [&](double at_x, double at_y, const char* anchor, const std::string& words,
                         const std::string& colour) {
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\" fill=\"{}\">{}</text>\n", at_x, at_y, anchor,
                       colour, words);
  };
  for (double d = low; d <= high; ++d) {
    line(x(std::pow(10, d)), kTop, x(std::pow(10, d)), kHeight - kBottom, "#dddddd");
    label(x(std::pow(10, d)), kHeight - kBottom + 18, "middle", time_text(std::pow(10, d)), "black");
  }
  for (double d = 0; d <= deep; ++d) {
    line(kLeft, y(std::pow(10, -d)), kWidth - kRight, y(std::pow(10, -d)), "#dddddd");
    label(kLeft - 8, y(std::pow(10, -d)) + 4, "end", d == 0 ? "all" : fmt::format("1 in {:g}", std::pow(10, d)),
          "black");
  }
  const double at_mark = x(static_cast<double>(mark_ns) * 1e-3);
  line(at_mark, kTop, at_mark, kHeight - kBottom, "#c00000");
  label(at_mark - 4, kHeight - kBottom - 6, "end", "deadline", "#c00000");
  double key_y = kTop + 16;
  for (const Curve& curve : curves) {
    const double all = static_cast<double>(curve.times->count());
    if (all == 0) continue;
    std::string points;
    std::uint64_t above = curve.times->count();
    for (std::uint32_t i = 0; i < Histogram::kBuckets && above > 0; ++i) {
      if (curve.times->in_bucket(i) == 0) continue;
      const double at_x = x(static_cast<double>(Histogram::upper_bound_ns(i)) * 1e-3);
      points += fmt::format("{:.1f},{:.1f} ", at_x, y(static_cast<double>(above) / all));
      above -= curve.times->in_bucket(i);
      if (above > 0) points += fmt::format("{:.1f},{:.1f} ", at_x, y(static_cast<double>(above) / all));
    }
    svg += fmt::format("<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"1.5\" points=\"{}\"/>\n", curve.colour,
                       points);
    label(kWidth - kRight - 8, key_y, "end", curve.name, curve.colour);
    key_y += 16;
  }
  label(0.5 * (kLeft + kWidth - kRight), kHeight - 12, "middle", "time; share of the ticks that took longer", "black");
  return svg + "</svg>\n";
}

}  // namespace tactus::timing
