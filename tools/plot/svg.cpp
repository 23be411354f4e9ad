#include "tools/plot/svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/xml_text.h"

namespace tactus::plot {
namespace {

constexpr double kLine = 16;  // from a line of text to the next

// Contrast of text to background at least 4.5 : 1, of curves 3 : 1, in light and dark mode; printed in light mode.
constexpr const char* kStyle =
    "<style>svg{--paper:#fff;--ink:#1a1a1b;--mute:#55595e;--grid:#e2e4e7;--c0:#0067a5;--c1:#c94f00;--c2:#00805d;"
    "--c3:#6b4fb3;background:var(--paper);color-scheme:light dark;max-width:100%;height:auto;"
    "font:12px 'DejaVu Sans',Verdana,sans-serif}"
    "@media screen and (prefers-color-scheme:dark){svg{--paper:#14171a;--ink:#e6e6e7;--mute:#a9afb6;--grid:#33383e;"
    "--c0:#5db5f2;--c1:#ff8d4d;--c2:#3fcfa3;--c3:#b9a6ff}}"
    "text{fill:var(--ink)}.answer{font-weight:bold;font-size:13px}.made{fill:var(--mute);font-size:11px}"
    ".boxed{fill:#1a1a1b}.grid{stroke:var(--grid)}"
    ".limit{stroke:var(--ink);stroke-dasharray:4 2 1 2;stroke-width:1.4}"
    ".series{fill:none}.s0{stroke:var(--c0);stroke-width:2.6}.s1{stroke:var(--c1);stroke-width:2;stroke-dasharray:7 3}"
    ".s2{stroke:var(--c2);stroke-width:1.6;stroke-dasharray:2 2}"
    ".s3{stroke:var(--c3);stroke-width:1.6;stroke-dasharray:8 3 2 3}"
    "circle.series{fill:var(--paper);stroke-dasharray:none}rect{stroke:var(--paper)}</style>\n";

const char* name_of(Anchor anchor) {
  return anchor == Anchor::kStart ? "start" : anchor == Anchor::kMiddle ? "middle" : "end";
}

bool is_figure(std::string_view word) {
  const auto in_number = [](char c) { return (c >= '0' && c <= '9') || c == '.' || c == '-'; };
  return !word.empty() && std::all_of(word.begin(), word.end(), in_number);
}

// As Drawing::paragraph.
std::vector<std::string> wrapped(std::string_view words, std::size_t most) {
  std::vector<std::string> lines{""};
  for (std::size_t at = 0; at < words.size();) {
    std::size_t end = std::min(words.find(' ', at), words.size());
    if (end < words.size() && is_figure(words.substr(at, end - at)))
      end = std::min(words.find(' ', end + 1), words.size());
    end = std::min(end, at + most);
    const std::string_view word = words.substr(at, end - at);
    if (!lines.back().empty() && lines.back().size() + 1 + word.size() > most) lines.emplace_back();
    if (!lines.back().empty()) lines.back() += ' ';
    lines.back() += word;
    at = end < words.size() && words[end] == ' ' ? end + 1 : end;
  }
  return lines;
}

}  // namespace

std::string number_text(double value) {
  return value < 1e6 ? fmt::format("{:g}", value) : fmt::format("{:.0e}", value);
}

void LogAxis::hold(double least, double most) {
  low = std::floor(std::log10(least));
  high = std::max(low + 1, std::ceil(std::log10(most)));
}

double LogAxis::at(double value) const {
  return start + (std::log10(std::max(value, std::pow(10, low))) - low) / (high - low) * (end - start);
}

std::vector<double> LogAxis::ticks() const {
  std::vector<double> values;
  const bool has_threes = threes && high - low <= 4;
  for (double exponent = low; exponent <= high; ++exponent) {
    values.push_back(std::pow(10, exponent));
    if (has_threes && exponent < high) values.push_back(3 * std::pow(10, exponent));
  }
  return values;
}

void Drawing::line(std::string_view kind, Point from, Point to) {
  elements_ += fmt::format("<line class=\"{}\" x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\"/>\n", kind,
                           from.x, from.y, to.x, to.y);
}

void Drawing::text(std::string_view kind, Point at, Anchor anchor, std::string_view words) {
  elements_ += fmt::format("<text class=\"{}\" x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n", kind, at.x,
                           at.y, name_of(anchor), xml_text(words));
}

double Drawing::paragraph(std::string_view kind, Point at, std::string_view words, std::size_t most) {
  for (const std::string& one : wrapped(words, most)) {
    text(kind, at, Anchor::kStart, one);
    at.y += kLine;
  }
  return at.y;
}

void Drawing::curve(std::size_t series, std::string_view name, const std::vector<Point>& points) {
  std::string list;
  for (const Point& point : points) list += fmt::format("{:.1f},{:.1f} ", point.x, point.y);
  elements_ +=
      fmt::format("<polyline class=\"series s{}\" data-series=\"{}\" points=\"{}\"/>\n", series, xml_text(name), list);
}

void Drawing::mark(std::size_t series, Point centre) {
  elements_ +=
      fmt::format("<circle class=\"series s{}\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.5\"/>\n", series, centre.x, centre.y);
}

void Drawing::box(Point corner, Size size, std::string_view fill) {
  elements_ += fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"{}\"/>\n",
                           corner.x, corner.y, size.width, size.height, xml_text(fill));
}

void Drawing::axes(const LogAxis& x, const LogAxis& y) {
  const double top = std::min(y.start, y.end), bottom = std::max(y.start, y.end);
  for (const double value : x.ticks()) {
    const double at = x.at(value);
    line("grid", {at, top}, {at, bottom});
    text("xtick", {at, bottom + 18}, Anchor::kMiddle, x.tick_text(value));
  }
  for (const double value : y.ticks()) {
    const double at = y.at(value);
    line("grid", {x.start, at}, {x.end, at});
    text("ytick", {x.start - 8, at + 4}, Anchor::kEnd, y.tick_text(value));
  }
  text("xlabel", {0.5 * (x.start + x.end), bottom + 38}, Anchor::kMiddle, x.label);
  text("ylabel", {8, top - 14}, Anchor::kStart, y.label);
}

std::string Drawing::svg(std::string_view title, Size size) const {
  return fmt::format(
             "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" "
             "viewBox=\"0 0 {0:.0f} {1:.0f}\" role=\"img\">\n<title>{2}</title>\n",
             size.width, size.height, xml_text(title)) +
         kStyle + elements_ + "</svg>\n";
}

}  // namespace tactus::plot
