#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tools/experiment/csv.h"
#include "tools/experiment/scaling.h"
#include "tools/json_report.h"
#include "tools/plot/svg.h"

namespace tactus::experiment {
namespace {

using nlohmann::ordered_json;

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
  constexpr plot::Size kSize{640, 420};
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
  if (rows.empty()) return plot::Drawing().svg("No step of the sweep of bodies was timed.", kSize);
  const std::string answer =
      fmt::format("The cost of a step grows with contact points to the power {:.2f}.", report.exponent);
  plot::Drawing drawing;
  drawing.text("answer", {8, 20}, plot::Anchor::kStart, answer);
  plot::LogAxis x{.start = 70, .end = kSize.width - 30, .label = "contact points [1]", .threes = true},
      y{.start = kSize.height - 50, .end = 60, .label = "median of a step [\u00b5s]", .threes = true};
  x.hold(few, many);
  y.hold(fast, slow);
  drawing.axes(x, y);
  std::vector<plot::Point> points;
  for (const ScalingRow* row : rows) points.push_back({x.at(row->contact_points), y.at(row->median_us)});
  drawing.curve(0, "median of a step", points);
  for (const plot::Point& point : points) drawing.mark(0, point);
  return drawing.svg(answer, kSize);
}

}  // namespace tactus::experiment
