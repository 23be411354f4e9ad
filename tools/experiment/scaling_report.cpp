#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "tools/experiment/csv.h"
#include "tools/experiment/scaling.h"
#include "tools/json_report.h"

namespace tactus::experiment {
namespace {

using nlohmann::ordered_json;

struct LogAxis {  // decades from the least to the most, on the page from `start` to `end`
  double low, high, start, end;

  static LogAxis over(double least, double most, double start, double end) {
    const double low = std::floor(std::log10(least)), high = std::ceil(std::log10(most));
    return {.low = low, .high = high > low ? high : low + 1, .start = start, .end = end};
  }
  double at(double value) const { return start + (std::log10(value) - low) / (high - low) * (end - start); }
};

ordered_json json_of(const std::vector<ScalingRow>& rows) {
  ordered_json list = ordered_json::array();
  for (const ScalingRow& row : rows)
    list.push_back(
        {{"sweep", row.sweep},
         {"bodies", row.bodies},
         {"sub_steps", row.sub_steps},
         {"threads", row.threads},
         {"size_ratio", row.size_ratio},
         {"contact_points", row.contact_points},
         {"touching_pairs", row.touching_pairs},
         {"median_us", row.median_us},
         {"p99_us", row.p99_us},
         {"broad_phase_us", row.broad_phase_us},
         {"ns_per_point", row.ns_per_point},
         {"instructions_per_step", row.instructions > 0 ? ordered_json(row.instructions) : ordered_json(nullptr)},
         {"failure", row.failure}});
  return list;
}

constexpr CsvColumn kScalingColumns[] = {
    {"sweep", "sweep"},
    {"bodies [1]", "bodies"},
    {"sub_steps [1]", "sub_steps"},
    {"threads [1]", "threads"},
    {"size_ratio [1]", "size_ratio"},
    {"contact_points [1]", "contact_points"},
    {"touching_pairs [1]", "touching_pairs"},
    {"median [us]", "median_us"},
    {"p99 [us]", "p99_us"},
    {"broad_phase [us]", "broad_phase_us"},
    {"per_point [ns]", "ns_per_point"},
    {"instructions_per_step [1]", "instructions_per_step"},
};

}  // namespace

std::string scaling_table(const ScalingReport& report) {
  std::string text = fmt::format("{:<10} {:>7} {:>9} {:>7} {:>6} {:>9} {:>9} {:>11} {:>11} {:>12} {:>9} {:>13}\n",
                                 "sweep", "bodies", "sub-steps", "threads", "sizes", "points", "touching", "median us",
                                 "p99 us", "broad ph. us", "ns/point", "instructions");
  for (const ScalingRow& row : report.rows) {
    text += fmt::format(
        "{:<10} {:>7} {:>9} {:>7} {:>6.0f} {:>9.0f} {:>9.0f} {:>11.1f} {:>11.1f} {:>12.1f} {:>9.0f} {:>13}\n",
        row.sweep, row.bodies, row.sub_steps, row.threads, row.size_ratio, row.contact_points, row.touching_pairs,
        row.median_us, row.p99_us, row.broad_phase_us, row.ns_per_point,
        row.instructions > 0 ? fmt::format("{:.0f}", row.instructions) : "-");
    if (!row.failure.empty()) text += fmt::format("           DOES NOT COUNT: {}\n", row.failure);
  }
  text += fmt::format("\ncost grows with contact points to the power {:.2f}", report.exponent);
  if (report.instruction_exponent > 0)
    text += fmt::format(", instructions to the power {:.2f}", report.instruction_exponent);
  return text +
         "\nCPU time of one thread, in the sweep of threads the wall clock; instructions: of a step, by callgrind.\n";
}

std::string scaling_json(const ScalingReport& report) {
  return report_text(
      ordered_json{{"rows", json_of(report.rows)},
                   {"exponent", report.exponent},
                   {"instruction_exponent", report.instruction_exponent > 0 ? ordered_json(report.instruction_exponent)
                                                                            : ordered_json(nullptr)}},
      2);
}

std::string scaling_csv(const ScalingReport& report) { return csv_of(kScalingColumns, json_of(report.rows)); }

std::string scaling_svg(const ScalingReport& report) {
  constexpr double kWidth = 640, kHeight = 420, kLeft = 70, kRight = 20, kTop = 30, kBottom = 50;
  std::vector<const ScalingRow*> rows;
  double few = 1e300, many = 0, fast = 1e300, slow = 0;
  for (const ScalingRow& row : report.rows) {
    if (row.sweep != "bodies" || !(row.contact_points > 0) || !(row.median_us > 0)) continue;
    rows.push_back(&row);
    few = std::min(few, row.contact_points);
    many = std::max(many, row.contact_points);
    fast = std::min(fast, row.median_us);
    slow = std::max(slow, row.median_us);
  }
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" font-family=\"sans-serif\" "
      "font-size=\"12\">\n<rect width=\"{0}\" height=\"{1}\" fill=\"white\"/>\n",
      kWidth, kHeight);
  if (rows.empty()) return svg + "</svg>\n";
  const LogAxis x = LogAxis::over(few, many, kLeft, kWidth - kRight),
                y = LogAxis::over(fast, slow, kHeight - kBottom, kTop);
  const auto line = [&](double x1, double y1, double x2, double y2, const char* colour) {
    svg += fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"{}\"/>\n", x1, y1, x2,
                       y2, colour);
  };
  const auto label = [&](double at_x, double at_y, const char* anchor, const std::string& words) {
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n", at_x, at_y, anchor, words);
  };
  for (double d = x.low; d <= x.high; ++d) {
    const double at = x.at(std::pow(10, d));
    line(at, y.start, at, y.end, "#dddddd");
    label(at, y.start + 18, "middle", fmt::format("{:g}", std::pow(10, d)));
  }
  for (double d = y.low; d <= y.high; ++d) {
    const double at = y.at(std::pow(10, d));
    line(x.start, at, x.end, at, "#dddddd");
    label(x.start - 8, at + 4, "end", fmt::format("{:g}", std::pow(10, d)));
  }
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double at_x = x.at(rows[i]->contact_points), at_y = y.at(rows[i]->median_us);
    if (i > 0) line(x.at(rows[i - 1]->contact_points), y.at(rows[i - 1]->median_us), at_x, at_y, "#1f5fa8");
    svg += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.5\" fill=\"#1f5fa8\"/>\n", at_x, at_y);
  }
  label(0.5 * (x.start + x.end), kHeight - 12, "middle", "contact points");
  label(x.start, kTop - 10, "start", fmt::format("median step [us]; grows to the power {:.2f}", report.exponent));
  return svg + "</svg>\n";
}

}  // namespace tactus::experiment
