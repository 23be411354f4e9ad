#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "sim/model/choice_names.h"
#include "tools/experiment/coupling/capacity.h"
#include "tools/experiment/csv.h"
#include "tools/json_report.h"

namespace tactus::experiment {
namespace {

using nlohmann::ordered_json;

ordered_json json_of(const std::vector<CapacityPoint>& points) {
  ordered_json list = ordered_json::array();
  for (const CapacityPoint& p : points)
    list.push_back({{"coupling", sim::name_of(p.scheme.coupling)},
                    {"rate_Hz", p.rate_Hz},
                    {"ratio", p.scheme.ratio},
                    {"bodies", p.bodies},
                    {"contact_points", p.contact_points},
                    {"tick_us_p50", p.tick_us_p50},
                    {"tick_us_p99", p.tick_us_p99},
                    {"step_us_p50", p.step_us_p50},
                    {"step_us_p90", p.step_us_p90},
                    {"fits", p.fits()}});
  return list;
}

constexpr CsvColumn kCapacityColumns[] = {
    {"coupling", "coupling"},
    {"rate [Hz]", "rate_Hz"},
    {"ratio [1]", "ratio"},
    {"bodies [1]", "bodies"},
    {"contact_points [1]", "contact_points"},
    {"tick_p50 [us]", "tick_us_p50"},
    {"tick_p99 [us]", "tick_us_p99"},
    {"global_step_p50 [us]", "step_us_p50"},
    {"global_step_p90 [us]", "step_us_p90"},
    {"fits", "fits"},
};

}  // namespace

std::string capacity_table(const CapacityReport& report) {
  std::string text = fmt::format("{:<14} {:>7} {:>5} {:>9} {:>9} {:>12} {:>14}\n", "coupling", "rate Hz", "ratio",
                                 "bodies", "too many", "times direct", "breaks by");
  for (const CapacityRow& row : report.rows)
    text += fmt::format(
        "{:<14} {:>7g} {:>5} {:>9} {:>9} {:>12} {:>14}\n", sim::name_of(row.scheme.coupling), row.rate_Hz,
        row.scheme.ratio, row.bodies, row.too_many > 0 ? fmt::format("{}", row.too_many) : "-",
        row.quotient > 0 ? fmt::format("{:.1f}", row.quotient) : "-", row.breaks.empty() ? "-" : row.breaks);
  return text +
         fmt::format(
             "\nCubes in a heap, all awake, stirred by the proxy; sub-world of {} members. CPU time, the least of up "
             "to {} "
             "identical\nruns, the global world {}: 99 of 100 ticks within the tick,\n9 of 10 global steps within "
             "their "
             "r ticks. The paper's rule: times direct is the ratio (50 cubes directly, 500 at\nratio 10, at 1 kHz).\n",
             report.members, report.runs,
             report.two_cores ? "on a core of its own" : "on the same core, whose caches it shares");
}

std::string capacity_json(const CapacityReport& report) {
  ordered_json rows = ordered_json::array();
  for (const CapacityRow& row : report.rows)
    rows.push_back({{"coupling", sim::name_of(row.scheme.coupling)},
                    {"rate_Hz", row.rate_Hz},
                    {"ratio", row.scheme.ratio},
                    {"bodies", row.bodies},
                    {"too_many", row.too_many > 0 ? ordered_json(row.too_many) : ordered_json(nullptr)},
                    {"breaks_by", row.breaks},
                    {"times_direct", row.quotient > 0 ? ordered_json(row.quotient) : ordered_json(nullptr)}});
  return report_text(ordered_json{{"rows", rows},
                                  {"points", json_of(report.points)},
                                  {"members", report.members},
                                  {"runs", report.runs},
                                  {"two_cores", report.two_cores}},
                     2);
}

std::string capacity_csv(const CapacityReport& report) { return csv_of(kCapacityColumns, json_of(report.points)); }

}  // namespace tactus::experiment
