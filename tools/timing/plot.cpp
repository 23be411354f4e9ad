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

// Contrast of text to background at least 4.5 : 1, of curves 3 : 1, in light and dark mode; printed in light mode.
constexpr const char* kStyle =
    "<style>svg{--paper:#fff;--ink:#1a1a1b;--mute:#55595e;--grid:#e2e4e7;--c0:#0067a5;--c1:#c94f00;--c2:#00805d;"
    "--c3:#6b4fb3;background:var(--paper);color-scheme:light dark;max-width:100%;height:auto;"
    "font:12px 'DejaVu Sans',Verdana,sans-serif}"
    "@media screen and (prefers-color-scheme:dark){svg{--paper:#14171a;--ink:#e6e6e7;--mute:#a9afb6;--grid:#33383e;"
    "--c0:#5db5f2;--c1:#ff8d4d;--c2:#3fcfa3;--c3:#b9a6ff}}"
    "text{fill:var(--ink)}.answer{font-weight:bold;font-size:13px}.made{fill:var(--mute);font-size:11px}"
    ".grid{stroke:var(--grid)}.limit{stroke:var(--ink);stroke-dasharray:4 2 1 2;stroke-width:1.4}"
    ".series{fill:none}.s0{stroke:var(--c0);stroke-width:2.6}.s1{stroke:var(--c1);stroke-width:2;stroke-dasharray:7 3}"
    ".s2{stroke:var(--c2);stroke-width:1.6;stroke-dasharray:2 2}"
    ".s3{stroke:var(--c3);stroke-width:1.6;stroke-dasharray:8 3 2 3}</style>\n";

std::string escaped(const std::string& words) {
  std::string text;
  for (const char c : words)
    text += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '"' ? "&quot;" : std::string(1, c);
  return text;
}

bool is_figure(std::string_view word) {
  const auto in_number = [](char c) { return (c >= '0' && c <= '9') || c == '.' || c == '-'; };
  return !word.empty() && std::all_of(word.begin(), word.end(), in_number);
}

// Wraps text to lines of at most `most` bytes, at spaces, but not between a number and its unit; a longer word is cut.
std::vector<std::string> wrapped(const std::string& words, std::size_t most) {
  std::vector<std::string> lines{""};
  for (std::size_t at = 0; at < words.size();) {
    std::size_t end = std::min(words.find(' ', at), words.size());
    if (end < words.size() && is_figure(std::string_view(words).substr(at, end - at)))
      end = std::min(words.find(' ', end + 1), words.size());
    end = std::min(end, at + most);
    const std::string word = words.substr(at, end - at);
    if (!lines.back().empty() && lines.back().size() + 1 + word.size() > most) lines.emplace_back();
    lines.back() += (lines.back().empty() ? "" : " ") + word;
    at = end < words.size() && words[end] == ' ' ? end + 1 : end;
  }
  return lines;
}

struct Decades {  // a logarithmic axis
  double low, high, start, end;
  double at(double value) const {
    return start + (std::log10(std::max(value, std::pow(10, low))) - low) / (high - low) * (end - start);
  }
};

class Drawing {
 public:
  void line(const char* kind, double x1, double y1, double x2, double y2) {
    text_ += fmt::format("<line class=\"{}\" x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\"/>\n", kind, x1, y1,
                         x2, y2);
  }
  void label(const char* kind, double x, double y, const char* anchor, const std::string& words) {
    text_ += fmt::format("<text class=\"{}\" x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n", kind, x, y,
                         anchor, escaped(words));
  }
  void curve(std::size_t i, const Curve& curve, const std::string& points) {
    text_ += fmt::format("<polyline class=\"series s{}\" data-series=\"{}\" points=\"{}\"/>\n", i, escaped(curve.name),
                         points);
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

std::string number_text(double value) {
  return value < 1e6 ? fmt::format("{:g}", value) : fmt::format("{:.0e}", value);
}

// From the start of the first curve to beyond the last curve and the deadline, in whole decades of us.
Decades time_axis(const std::vector<Curve>& curves, double mark_us) {
  double shortest_us = mark_us, longest_us = 2 * mark_us;
  for (const Curve& curve : curves) {
    if (curve.times->count() == 0) continue;
    longest_us = std::max(longest_us, static_cast<double>(curve.times->max_ns()) * 1e-3);
    std::uint32_t first = 0;
    while (first + 1 < Histogram::kBuckets && curve.times->in_bucket(first) == 0) ++first;
    shortest_us = std::min(shortest_us, static_cast<double>(Histogram::upper_bound_ns(first)) * 1e-3);
  }
  const double low = std::floor(std::log10(std::max(shortest_us, 0.01)) + 1e-9);
  return {
      .low = low, .high = std::max(low + 1, std::ceil(std::log10(longest_us))), .start = kLeft, .end = kWidth - kRight};
}

// The share of the ticks that took longer, as steps.
std::string falling(const Histogram& times, const Decades& x, const Decades& y) {
  const double all = static_cast<double>(times.count());
  std::uint64_t above = times.count();
  std::string points = fmt::format("{:.1f},{:.1f} ", x.start, y.at(1));
  for (std::uint32_t i = 0; i < Histogram::kBuckets && above > 0; ++i) {
    if (times.in_bucket(i) == 0) continue;
    const double at_x = x.at(static_cast<double>(Histogram::upper_bound_ns(i)) * 1e-3);
    points += fmt::format("{:.1f},{:.1f} ", at_x, y.at(all / static_cast<double>(above)));
    above -= times.in_bucket(i);
    if (above > 0) points += fmt::format("{:.1f},{:.1f} ", at_x, y.at(all / static_cast<double>(above)));
  }
  return points;
}

// The vertical axis goes from all ticks at the top to one tick.
void draw_axes(Drawing& drawing, const Decades& x, const Decades& y) {
  const double top = y.start, bottom = y.end;
  for (double d = x.low; d <= x.high; ++d)
    for (const double lead : {1.0, 3.0}) {
      const double value = lead * std::pow(10, d);
      if (lead > 1 && (d == x.high || x.high - x.low > 4)) continue;
      drawing.line("grid", x.at(value), top, x.at(value), bottom);
      drawing.label("xtick", x.at(value), bottom + 18, "middle", number_text(value));
    }
  for (double d = y.low; d <= y.high; ++d) {
    const double at = y.at(std::pow(10, d));
    drawing.line("grid", x.start, at, x.end, at);
    drawing.label("ytick", x.start - 8, at + 4, "end", d == 0 ? "all" : "1 in " + number_text(std::pow(10, d)));
  }
  drawing.label("xlabel", 0.5 * (x.start + x.end), bottom + 38, "middle", "time [\u00b5s]");
  drawing.label("ylabel", 8, top - 14, "start", "ticks that took longer [1 in N]");
}

// Draws the legend; returns its lower end.
double draw_key(Drawing& drawing, const std::vector<const Curve*>& drawn, double mark_us, double top) {
  for (std::size_t i = 0; i < drawn.size(); ++i, top += kLine) {
    drawing.line(fmt::format("series s{}", i).c_str(), 8, top - 4, 48, top - 4);
    drawing.label("key", 56, top, "start", drawn[i]->name);
  }
  drawing.line("limit", 8, top - 4, 48, top - 4);
  drawing.label("key", 56, top, "start", "deadline, " + time_text(mark_us));
  return top + kLine;
}

}  // namespace

std::string histogram_svg(const std::string& sentence, const Provenance& made, const std::vector<Curve>& curves,
                          std::int64_t mark_ns) {
  Drawing drawing;
  double top = 24;
  const auto write = [&](const char* kind, const std::string& words, std::size_t most) {
    for (const std::string& line : wrapped(words, most)) {
      drawing.label(kind, 8, top, "start", line);
      top += kLine;
    }
    top += 3;
  };
  write("answer", sentence, kWordsBold);
  for (const std::string& words :
       {fmt::format("date: {}; version: {}, built for {}", made.date_utc, made.version, made.built_for),
        "machine: " + made.machine, "command: " + made.command})
    write("made", words, kWords);
  std::vector<const Curve*> drawn;
  std::uint64_t most = 10;
  for (const Curve& curve : curves)
    if (curve.times->count() > 0) {
      drawn.push_back(&curve);
      most = std::max(most, curve.times->count());
    }
  const double mark_us = static_cast<double>(mark_ns) * 1e-3;
  top = draw_key(drawing, drawn, mark_us, top + 10) + 34;
  const Decades x = time_axis(curves, mark_us);
  const Decades y{.low = 0,
                  .high = std::ceil(std::log10(static_cast<double>(most)) - 1e-9),
                  .start = top,
                  .end = top + kPlotHeight};
  draw_axes(drawing, x, y);
  for (std::size_t i = 0; i < drawn.size(); ++i) drawing.curve(i, *drawn[i], falling(*drawn[i]->times, x, y));
  drawing.line("limit", x.at(mark_us), y.start, x.at(mark_us), y.end);
  const double height = y.end + 52;
  return fmt::format(
             "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1:.0f}\" viewBox=\"0 0 {0} {1:.0f}\" "
             "role=\"img\">\n<title>{2}</title>\n",
             kWidth, height, escaped(sentence)) +
         kStyle + drawing.text() + "</svg>\n";
}

}  // namespace tactus::timing
